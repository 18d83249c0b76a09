"""fledge teaches a drone a composite skill from demonstrations of its simple parts.

The usual way: `fledge reproduce` runs the whole study; `demonstrate`, `train`, `evaluate` and `replay` are its steps, one
by one. `fledge COMMAND --help` explains each. Whatever goes wrong ends in one line on standard error and an exit
code other than 0.
"""

import json
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from fledge import console, doctor, lookup
from fledge.errors import BadFile, FledgeError, OutOfRange, UnknownName

if TYPE_CHECKING:
    from fledge.demonstrations import Order
    from fledge.episode import Flight
    from fledge.experiments import Results, Setup, Study
    from fledge.manoeuvres import AbstractManoeuvre
    from fledge.pilots import AbstractPilot

Json = Annotated[Path | None, tyro.conf.arg(metavar="FILE")]
"""Also write the result as JSON; - for standard output."""


def main(arguments: Sequence[str] | None = None) -> None:
    """The entry point: run a command, turn a user's error into one line."""
    try:
        tyro.extras.subcommand_cli_from_dict(
            {
                "reproduce": reproduce,
                "demonstrate": demonstrate,
                "train": train,
                "evaluate": evaluate,
                "replay": replay,
                "doctor": examine,
            },
            prog="fledge",
            description=__doc__,
            args=arguments,
        )
    except FledgeError as error:
        console.note(f"fledge: {error}")
        sys.exit(2)
    except KeyboardInterrupt:
        console.note("fledge: interrupted; what was finished is stored")
        sys.exit(130)


def demonstrate(
    out: Path = Path("demos"),
    manoeuvre: tuple[str, ...] = (),
    episodes: int | None = None,
    minutes: float | None = None,
    pilot: str = "human-model",
    seed: int = 0,
    json: Json = None,
) -> None:
    """Let a pilot fly demonstrations, and store each flight as one MCAP file.

    By default the paper's: 5, 10, 10 and 10 episodes of Fixed-altitude, Climb, Descend and Combined with 5,296,
    4,691, 4,904 and 5,464 rows. Killed and run again, it goes on where it was.

    Args:
        out: Folder for the flights.
        manoeuvre: Which to fly: names, or package.module:Name of your own. All four by default.
        episodes: Flights of each manoeuvre.
        minutes: Length of every flight; the paper's text says 10 and 5, its row counts say less (D4).
        pilot: Who flies: human-model, servo, or package.module:Name of your own.
        seed: Another seed, other flights.
        json: Also write a summary to this file, or to - for standard output.
    """
    orders = _orders(manoeuvre, episodes, minutes)
    flights = fly_demonstrations(out, orders, _pilot(pilot), seed)
    rows = {order.manoeuvre.name: 0 for order in orders}
    for flight in flights:
        rows[flight.manoeuvre] += flight.rows
    summary = {"folder": str(out), "seed": seed, "pilot": pilot, "flights": len(flights), "rows": rows}
    _tell(summary, json, f"{len(flights)} flights in {out}: " + ", ".join(f"{k} {v:,} rows" for k, v in rows.items()))


def train(
    demos: tyro.conf.Positional[Path],
    setup: str = "primitive",
    recipe: Literal["fast", "paper"] = "fast",
    epochs: int | None = None,
    out: Path = Path("policy.onnx"),
    seed: int = 0,
    resume: bool = False,
    json: Json = None,
) -> None:
    """Fuse stored demonstrations (Algorithm 1), train the network, store it as ONNX.

    Args:
        demos: Folder of flights from `fledge demonstrate`.
        setup: What to learn from, and how: primitive, primitive-paper, dnn-combined, ...
        recipe: The optimiser: fast (seconds) or paper (full batch, 10,000 epochs).
        epochs: Another number of epochs than the recipe's.
        out: The policy's file. Checkpoints stand beside it until it is done.
        seed: Initial weights and order of rows.
        resume: Go on from the checkpoint that an interrupted training left.
        json: Also write the losses to this file, or to - for standard output.
    """
    from fledge import training
    from fledge.experiments import by_sub_task, composite_set

    plan = _setup(setup)
    assert plan.trained_on
    chosen = training.Recipe.paper() if recipe == "paper" else training.Recipe.fast()
    if epochs is not None:
        chosen = replace(chosen, epochs=epochs).checked()
    flights = _read_flights(demos)
    composite, delay = composite_set(plan.trained_on, plan.method, by_sub_task(flights, plan.trained_on))
    policy, curve = _train_with_checkpoints(composite, chosen, seed, out, resume, _contract(flights[0]))
    from fledge.storage import write_policy

    write_policy(out, policy)
    _checkpoint_file(out).unlink(missing_ok=True)
    last = {"training": float(curve.training[-1, 0]), "validation": float(curve.validation[:, 0].min())}
    summary = {"policy": str(out), "setup": setup, "rows": len(composite.states), "delay_rows": delay}
    summary |= {"epochs": curve.epochs.tolist(), "loss": last}
    summary |= {"recipe": asdict(chosen), "seed": seed, "data": composite.digest()}
    _tell(
        summary,
        json,
        f"{out}: {setup} on {len(composite.states):,} rows, mean squared error {last['training']:.4f} in training, "
        f"{last['validation']:.4f} held out",
    )


def evaluate(
    policies: tyro.conf.Positional[tuple[str, ...]],
    manoeuvre: str = "combined",
    cases: int = 200,
    seed: int = 0,
    json: Json = None,
) -> None:
    """Fly policies on the same random test cases and compare them, paired.

    Args:
        policies: ONNX files, or names of pilots (servo, human-model, package.module:Name).
        manoeuvre: What the UGVs do: combined, fixed-altitude, climb, descend, or package.module:Name.
        cases: How many flights of 60 s each flies.
        seed: Another seed, other cases.
        json: Also write scores and comparisons to this file, or to - for standard output.
    """
    from fledge.experiments import duel

    if not policies:
        raise FledgeError("no policy given: name one or more ONNX files or pilots")
    if cases < 2:
        raise OutOfRange("cases", cases, "2 or more")
    crews = {name: _policy_or_pilot(name) for name in policies}
    test = next((m for m in _test_manoeuvres() if m.name == manoeuvre), None) or _manoeuvre(manoeuvre)
    with console.progress() as bar:
        found = duel(crews, test, cases, seed, lambda done: bar.update("flying", done, len(crews)))
    _print_scores(f"{manoeuvre}: {cases} flights of 60 s each", found["entries"])
    _print_comparisons(found["comparisons"])
    _tell(found | {"manoeuvre": manoeuvre, "seed": seed}, json)


def reproduce(
    quick: bool = False,
    full: bool = False,
    seed: int = 0,
    out: Path = Path("report"),
    json: Json = None,
) -> None:
    """Run the paper's study: demonstrate, fuse, train, fly, compare, report.

    Leaves report/index.html, results.json, figures, policies, the demonstrations and sample flights.

    Args:
        quick: One training seed; under a minute.
        full: 20 training seeds, every set-up, the paper's 10,000 epochs; under half an hour.
        seed: Another seed, other demonstrations and test cases.
        out: Folder for everything.
        json: Also write the results to this file, or to - for standard output.
    """
    if quick and full:
        raise FledgeError("--quick and --full exclude each other: give one, or neither")
    from fledge.demonstrations import PAPER_ORDERS
    from fledge.experiments import Study
    from fledge.pilots import HumanModel

    study = Study.of("full" if full else "quick" if quick else "brief", seed)
    times = {"start": time.perf_counter()}
    fly_demonstrations(out / "demonstrations", PAPER_ORDERS, HumanModel(), seed)
    times["demonstrations"] = time.perf_counter()
    results = _run(study, _read_flights(out / "demonstrations"))
    times["study"] = time.perf_counter()
    _store(results, out)
    times["files"] = time.perf_counter()
    from fledge.report import write_report
    from fledge.storage import write_json

    summary: dict[str, Any] = results.summary | {"times": _seconds(times)}
    write_json(out / "results.json", summary)
    page = write_report(out)
    _print_scores("Combined test flights", summary["setups"])
    _print_comparisons(summary["comparisons"][:4])
    console.say(summary["operator"]["sentence"])
    _tell(summary, json, f"report: {page}")


def replay(
    flight: tyro.conf.Positional[Path],
    out: Path | None = None,
    json: Json = None,
) -> None:
    """Draw a stored flight and print its figures. The file itself opens in Foxglove, too.

    Args:
        flight: An MCAP file.
        out: The picture: .png, .svg or .pdf, or .gif for an animation. Beside the flight by default.
        json: Also write the figures to this file, or to - for standard output.
    """
    from fledge.evaluation import Score, score
    from fledge.figures import draw_flight
    from fledge.simulation import Rig
    from fledge.storage import read_flight

    stored = read_flight(flight)
    picture = draw_flight(stored, out or flight.with_suffix(".png"))
    scores = score(stored.episode, replace(Rig(), lens=stored.lens, ideal_radius=stored.ideal_radius))
    figures = {name: float(getattr(scores, name)) for name in Score.names()}
    about = {"manoeuvre": stored.manoeuvre, "pilot": stored.pilot, "net": stored.net, "rows": stored.rows}
    about |= {"seed": stored.seed, "case": stored.case}
    console.say("  ".join(f"{key} {value}" for key, value in about.items()))
    _print_scores(str(flight), {stored.pilot: {f"{k}": v for k, v in figures.items()} | {"flights": 1}})
    _tell(about | {"scores": figures, "picture": str(picture)}, json, f"picture: {picture}")


def examine(json: Json = None) -> None:
    """Say what is installed, what is missing for what, and what to type.

    Args:
        json: Also write the findings to this file, or to - for standard output.
    """
    findings = doctor.examine()
    for finding in findings:
        console.say(f"{'ok     ' if finding.ok else 'missing'}  {finding.what}: {finding.found}")
        if finding.remedy:
            console.say(f"         {finding.remedy}")
    _tell({"findings": [asdict(finding) for finding in findings]}, json)
    if not all(finding.ok or finding.optional for finding in findings):
        sys.exit(1)


# The steps, shared by commands


def fly_demonstrations(
    out: Path, orders: "Sequence[Order]", pilot: "AbstractPilot", seed: int
) -> "list[Flight]":
    """Fly and store what is missing; every flight stands whole under its name, or not at all."""
    from fledge.demonstrations import collect
    from fledge.storage import sweep, write_flight

    if seed < 0:
        raise OutOfRange("seed", seed, "0 or more")
    _make_folder(out)
    sweep(out)
    stored = {path.name: flight for path, flight in _stored(out)}
    for name, flight in stored.items():
        if (flight.seed, flight.pilot) != (seed, pilot.name):
            raise FledgeError(
                f"{out / name} was flown by {flight.pilot} with seed {flight.seed}, not by {pilot.name} with seed "
                f"{seed}: give another --out, or the same pilot and seed"
            )
    wanted = {
        f"{order.manoeuvre.name}-{i:03d}.mcap": rows for order in orders for i, rows in enumerate(order.lengths())
    }
    if all(name in stored and stored[name].rows == rows for name, rows in wanted.items()):
        return [stored[name] for name in wanted]
    flights = []
    with console.progress() as bar:
        bar.update("demonstrations", 0, len(wanted))
        for flight in collect(orders, pilot, seed):
            path = out / f"{flight.manoeuvre}-{flight.case:03d}.mcap"
            if path.name not in stored or stored[path.name].rows != flight.rows:
                write_flight(path, flight)
            flights.append(flight)
            bar.update("demonstrations", len(flights), len(wanted))
    return flights


def _run(study: "Study", flights: "list[Flight]") -> "Results":
    from fledge.experiments import Progress, run

    with console.progress() as bar:
        for event in run(study, flights):
            if not isinstance(event, Progress):
                return event
            stage = event.stage if ":" in event.stage else "study"
            bar.update(stage, event.done, event.total)
    raise AssertionError("a study ends with its results")


def _store(results: "Results", out: Path) -> None:
    """Policies of the first seed, and one sample flight per set-up."""
    from fledge.storage import write_flight, write_policy
    from fledge.training import member

    for folder in (out / "policies", out / "flights"):
        _make_folder(folder)
    for name, result in results.setups.items():
        write_flight(out / "flights" / f"{name}.mcap", result.sample)
        if result.policy is not None:
            write_policy(out / "policies" / f"{name}.onnx", member(result.policy, 0))


def _train_with_checkpoints(
    composite: Any, recipe: Any, seed: int, out: Path, resume: bool, contract: Any
) -> tuple[Any, Any]:
    from fledge import training
    from fledge.storage import read_checkpoint, write_checkpoint

    path, key = _checkpoint_file(out), 1000 * seed
    settings = {"data": composite.digest(), "recipe": asdict(recipe), "seed": seed}
    state = None
    if resume and path.exists():
        arrays, stored = read_checkpoint(path)
        _same_run(path, settings, stored)
        state = training.restore(composite, recipe, [key], arrays)
    elif resume:
        console.note(f"no checkpoint at {path}: training starts from the beginning")
    _make_folder(out.parent)
    with console.progress() as bar:
        for state in training.train(composite, recipe, [key], state):
            write_checkpoint(path, training.arrays(state), settings)
            bar.update("training", state.epoch, recipe.epochs)
    assert state is not None
    many = training.policies(composite, recipe, state, contract)
    return training.member(many, 0), training.member_curve(state.curve, 0)


def _same_run(path: Path, wanted: dict[str, Any], stored: dict[str, Any]) -> None:
    for name, value in wanted.items():
        if stored.get(name) != value:
            raise BadFile(
                path,
                f"this checkpoint belongs to another training ({name} = {stored.get(name)}, now {value}): train "
                "without --resume, or with the same data, recipe and seed",
            )


def _checkpoint_file(out: Path) -> Path:
    return out.with_name(out.name + ".checkpoint.npz")


# From names and files to what they mean


def _pilot(name: str) -> "AbstractPilot":
    from fledge.pilots import AbstractPilot

    return lookup.find("fledge.pilots", AbstractPilot, name)


def _manoeuvre(name: str) -> "AbstractManoeuvre":
    from fledge.manoeuvres import AbstractManoeuvre

    return lookup.find("fledge.manoeuvres", AbstractManoeuvre, name)


def _test_manoeuvres() -> "tuple[AbstractManoeuvre, ...]":
    from fledge.experiments import TEST_MANOEUVRES

    return TEST_MANOEUVRES


def _setup(name: str) -> "Setup":
    from fledge.experiments import BASIC, FURTHER

    known = {setup.name: setup for setup in BASIC + FURTHER if setup.trained_on and setup.rows is None}
    if name not in known:
        raise UnknownName("set-up", name, known)
    return known[name]


def _policy_or_pilot(name: str) -> "AbstractPilot":
    if name.endswith(".onnx") or Path(name).is_file():
        from fledge.policy import Contract
        from fledge.storage import read_policy

        policy = read_policy(Path(name))
        if policy.contract is None:
            raise BadFile(name, "a policy without a contract: it was not trained to fly")
        policy.contract.check(Contract())
        return policy
    return _pilot(name)


def _orders(names: tuple[str, ...], episodes: int | None, minutes: float | None) -> "list[Order]":
    from fledge.demonstrations import PAPER_ORDERS, Order
    from fledge.observation import ROW_RATE

    if episodes is not None and not 1 <= episodes <= 1000:
        raise OutOfRange("episodes", episodes, "1 to 1000")
    if minutes is not None and not 0.1 <= minutes <= 60.0:
        raise OutOfRange("minutes", minutes, "0.1 to 60")
    paper = {order.manoeuvre.name: order for order in PAPER_ORDERS}
    orders = []
    for name in names or tuple(paper):
        order = paper.get(name) or Order(_manoeuvre(name), 10, 5000)
        count = episodes or order.episodes
        rows = round(minutes * 60 * ROW_RATE) * count if minutes else order.rows * count // order.episodes
        orders.append(Order(order.manoeuvre, count, rows))
    return orders


def _read_flights(folder: Path) -> "list[Flight]":
    flights = [flight for _, flight in _stored(folder)]
    if not flights:
        raise BadFile(folder, "no flights (*.mcap) here; `fledge demonstrate` makes them")
    return flights


def _stored(folder: Path) -> "list[tuple[Path, Flight]]":
    from fledge.storage import list_flights, read_flight

    if not folder.is_dir():
        raise BadFile(folder, "no such folder")
    return [(path, read_flight(path)) for path in list_flights(folder)]


def _contract(flight: "Flight") -> Any:
    from fledge.policy import Contract

    return Contract(lens=flight.lens, ideal_radius=flight.ideal_radius, sticks=flight.sticks)


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadFile(folder, f"cannot be made: {error.strerror}") from error


# What is shown


def _tell(summary: dict[str, Any], file: Path | None, line: str = "") -> None:
    """The last line for people, and everything for machines."""
    if line and str(file) != "-":
        console.say(line)
    if str(file) == "-":
        print(json.dumps(summary, indent=1, sort_keys=True, default=str))
    elif file is not None:
        from fledge.storage import write_json

        write_json(file, summary)


def _print_scores(title: str, entries: dict[str, dict[str, Any]]) -> None:
    columns = ("", "flights", "distance px", "radius px2", "distance RMSE px", "radius RMSE px", "in view %", "smoothness 1/s")
    rows = [
        (
            name,
            str(found["flights"]),
            _spread(found["distance"]),
            _spread(found["radius"]),
            f"{found.get('distance_rmse_px', found.get('distance_rmse')):.2f}",
            f"{found.get('radius_rmse_px', found.get('radius_rmse')):.2f}",
            f"{100.0 * found['in_view']:.2f}",
            f"{found['smoothness']:.2f}",
        )
        for name, found in entries.items()
    ]
    console.table(title, columns, rows)


def _spread(value: Any) -> str:
    return f"{value['mean']:.1f} ± {value['sd']:.1f}" if isinstance(value, dict) else f"{value:.1f}"


def _print_comparisons(comparisons: list[dict[str, Any]]) -> None:
    if not comparisons:
        return
    rows = [
        (
            f"{c['a']} - {c['b']}",
            c["metric"],
            f"{c['difference']:+.2f}",
            f"[{c['interval'][0]:+.2f}, {c['interval'][1]:+.2f}]",
            f"{c['p_holm']:.4f}",
            f"{c['effect_size']:+.2f}",
        )
        for c in comparisons
    ]
    console.table("Paired comparisons", ("", "metric", "difference", "95 % interval", "p (Holm)", "effect d_z"), rows)


def _seconds(times: dict[str, float]) -> dict[str, float]:
    names = list(times)
    return {b: round(times[b] - times[a], 1) for a, b in zip(names[:-1], names[1:], strict=True)}
