"""Stored flights, as a page is shown them: which there are, and one of them whole, column by column.

A flight is called by its path within the folder, without its suffix: `climb-000`, `flights/combined-003`. Only what is
listed can be had, so no name leads out of the folder.
"""

from contextlib import suppress
from dataclasses import astuple, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from fledge.camera import look
from fledge.cockpit.tells import Marks
from fledge.episode import Flight
from fledge.errors import BadFile, UnknownName
from fledge.observation import ROW_RATE
from fledge.simulation import Rig
from fledge.storage import read_facts, read_flight
from fledge.storage.atomic import reading
from fledge.study.evaluation import score
from fledge.world import Arena, Reason, UavState, Verdict, WorldState

UAV, UGV = "UAV", "UGV"


class Shelf:
    """The flights in a folder, and in the one within it where those are that somebody else than a person flew."""

    def __init__(self, demos: Path, flights: Path) -> None:
        self._folders = {"": demos, f"{flights.name}/": flights}
        self._facts: dict[tuple[Path, int], dict[str, Any] | None] = {}
        """By path and time of its last change; None for what is no flight."""

    def listing(self) -> list[dict[str, Any]]:
        """What there is, the newest first."""
        found = []
        for name, path in self._paths().items():
            with suppress(FileNotFoundError):  # removed meanwhile
                facts, modified = self._about(path), path.stat().st_mtime
                if facts is not None:
                    some = {key: facts[key] for key in ("manoeuvre", "pilot", "net", "rows", "case", "seed")}
                    about = {"seconds": facts["rows"] / ROW_RATE, "modified": modified}
                    found.append({"name": name, **some, **about})
        return sorted(found, key=lambda one: (-one["modified"], one["name"]))

    def whole(self, name: str) -> dict[str, Any]:
        """A flight, as plain JSON values.

        Raises:
            UnknownName: there is none of that name.
            BadFile: it cannot be read.
        """
        paths = self._paths()
        if name not in paths:
            raise UnknownName("flight", name, sorted(paths))
        flight = read_flight(paths[name])
        some = {key: getattr(flight, key) for key in ("manoeuvre", "pilot", "net", "seed", "case", "rows")}
        # Where somebody was lost, there are numbers that are none.
        with reading(paths[name], "a flight"), np.errstate(invalid="ignore"):
            columns, how_well = _columns(flight), _plain(astuple(marks(flight)))
        return {
            "name": name,
            **some,
            "axes": list(flight.axes),
            **hall(flight.arena),
            "lens": lens(flight),
            "ideal_radius": flight.ideal_radius,
            "names": names(flight.episode.world),
            "marks": dict(zip(("distance", "radius", "in_view"), how_well, strict=True)),
            "columns": columns,
        }

    def _paths(self) -> dict[str, Path]:
        return {
            f"{within}{path.stem}": path
            for within, folder in self._folders.items()
            for path in sorted(folder.glob("*.mcap"))
            if not path.name.startswith(".")
        }

    def _about(self, path: Path) -> dict[str, Any] | None:
        key = path, path.stat().st_mtime_ns
        if key not in self._facts:
            try:
                self._facts[key] = read_facts(path)
            except BadFile:
                self._facts[key] = None
        return self._facts[key]


def marks(flight: Flight) -> Marks:
    """How well it was flown."""
    rig = replace(Rig(), lens=flight.lens, ideal_radius=flight.ideal_radius)
    found = score(flight.episode, rig)
    return Marks(float(found.distance_rmse), float(found.radius_rmse), float(found.in_view))


def hall(arena: Arena) -> dict[str, Any]:
    """The arena and its obstacles, each as a `tells.Block`."""
    blocks = [(arena.bounds, arena.ceiling), *((one.footprint, one.height) for one in arena.obstacles)]
    room, *boxes = (
        {side.name: getattr(box, side.name) for side in fields(box)} | {"height": height}
        for box, height in blocks
    )
    return {"arena": room, "obstacles": boxes}


def lens(about: Flight) -> dict[str, float]:
    """The lens, as a `tells.View`."""
    return {"focal": about.lens.focal_px, "width": about.lens.width_px, "height": about.lens.height_px}


def names(world: WorldState) -> list[str]:
    """What people call the vehicles."""
    return [UAV, *(f"{UGV} {i}" for i, _ in enumerate(world.ugvs, start=1))]


def _columns(flight: Flight) -> dict[str, Any]:
    episode, world = flight.episode, flight.episode.world
    picture = look(flight.lens, world)
    seen = [np.stack(flight.lens.project(world.uav, ugv.x, ugv.y), axis=-1) for ugv in world.ugvs]
    action = [getattr(episode.action, axis.name) for axis in fields(episode.action)]
    vehicles = zip((world.uav, *world.ugvs), episode.verdicts, strict=True)
    return {
        "t": _plain(world.t),
        "vehicles": [_vehicle(state, verdict) for state, verdict in vehicles],
        "picture": {
            **{name: _plain(getattr(picture, name)) for name in ("u", "v", "radius")},
            "marks": _plain(np.stack(seen, axis=1)),
        },
        "action": _plain(np.stack(action, axis=-1)),
    }


def _vehicle(state: Any, verdict: Verdict) -> dict[str, Any]:
    if isinstance(state, UavState):
        heading = state.attitude.heading()
        place = state.position.x, state.position.y, state.position.z, np.arctan2(heading.sin, heading.cos)
    else:
        place = state.x, state.y, 0.0 * state.x, state.heading
    sent = [getattr(verdict.command, axis.name) for axis in fields(verdict.command)]
    return {
        **{name: _plain(column) for name, column in zip(("x", "y", "z", "heading"), place, strict=True)},
        "intervened": [int(one > 0.5) for one in np.asarray(verdict.intervened).tolist()],
        "reason": [Reason(int(one)).name for one in np.asarray(verdict.reason).tolist()],
        "clearance": _plain(verdict.clearance),
        "sent": _plain(np.stack(sent, axis=-1)),
    }


def _plain(column: Any) -> list[Any]:
    """To five digits behind the point; what is no number is null."""
    values = np.asarray(column, float)
    rounded = np.round(values, 5).astype(object)
    rounded[~np.isfinite(values)] = None
    return rounded.tolist()
