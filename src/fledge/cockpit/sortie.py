"""One flight that was chosen: its scene, 10 ms after 10 ms, and its recording, if there is to be one."""

from dataclasses import replace
from pathlib import Path

from fledge.cockpit.asks import Fly
from fledge.cockpit.scene import Scene, Shown
from fledge.cockpit.screen import frame
from fledge.cockpit.seat import Spoken
from fledge.cockpit.tape import Tape
from fledge.cockpit.tells import Frame
from fledge.errors import FledgeError
from fledge.supervision.supervisor import IDLE


class Sortie:
    """What the deck moves. A recording waits to be kept or thrown away, also when its flight is over."""

    def __init__(self, fly: Fly, scene: Scene, tape: Tape | None = None) -> None:
        self.fly, self.scene, self.tape = fly, scene, tape
        self._memory = scene.init()
        self._shown: Shown | None = None
        self._told = ""
        """The problem of the recording that was told of."""

    @property
    def is_recorded(self) -> bool:
        """Whether the manoeuvre that is recorded is over."""
        return self.tape is not None and self._shown is not None and self._shown.over

    def tick(self, spoken: Spoken) -> str:
        """10 ms later, with what people said; what is wrong with the recording, if that is new."""
        self._memory, self._shown = self.scene.tick(self._memory, spoken)
        return self._record(self.tape, self._shown)

    def frame(self) -> Frame | None:
        """What there is to be seen now; nothing before the first tick."""
        if self._shown is None:
            return None
        told = frame(self._shown, self.scene.about, self.scene.halts(self._memory))
        return told if self.tape is None else replace(told, rows=self.tape.rows)

    def keep(self) -> Path:
        """The recording, as a flight on disk.

        Raises:
            FledgeError: there is none.
            BadFile: it cannot be written, or has no rows.
        """
        tape, self.tape = self.tape, None
        if tape is None:
            raise FledgeError("nothing was recorded that could be kept")
        return tape.keep()

    def discard(self) -> None:
        """The recording is not wanted."""
        if self.tape is not None:
            self.tape.discard()
            self.tape = None

    def close(self) -> None:
        """Nothing goes on; what was being recorded stays on disk, to be recovered."""
        if self.tape is not None:
            self.tape.leave()
        self.scene.close()

    def _record(self, tape: Tape | None, shown: Shown) -> str:
        if tape is None or shown.row is None:
            return ""
        airborne = int(shown.decisions[0].mode) not in IDLE
        if shown.flown if self.fly.record == "demonstration" else airborne:
            tape.add(shown.row)
        if tape.problem == self._told:
            return ""
        self._told = tape.problem
        return tape.problem
