"""What the twin's bottom camera sees, while somebody looks.

    the twin's tick  --newest poses-->  whoever iterates `frames`  <--pixels--  a process of its own (`darkroom`)

The tick leaves its poses and goes on: it never waits, for the newest alone are kept. A frame takes the newest, has them
rendered, and is handed over, up to 30 times a second; so it is never older than the time that rendering takes. Nobody
iterates: no process, and poses are not even asked for (`watched`). Each iteration has a process of its own, which is
started by the first step and ended with the iteration, and which ends by itself if this process is gone.

The camera hangs under the airframe and tilts with it, as the real one does: where the pilot's lens is levelled
(`camera.Lens`), the picture still is not. Its field of view is the lens's. A frame is raw: red, green, blue. Real
pictures are blurred, distorted, late and full of noise; these are not, and no pilot of fledge reads them.

Without a way to draw (MuJoCo asks EGL, or what MUJOCO_GL names) there are no frames: that is told once, in a line, and
the twin flies on.

`screening` puts the frames on `/ardrone/bottom/image_raw` for as long as that topic has subscribers.
"""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from itertools import chain, count
from threading import Event, Lock, Thread
from typing import NamedTuple, Protocol

from fledge.camera import Lens
from fledge.geometry import Quat, Vec3
from fledge.lab.twin import darkroom
from fledge.lab.twin.bodies import Airframe
from fledge.lab.twin.scene import mjcf
from fledge.lab.wire import topics
from fledge.lab.wire.datagrams import Datagram
from fledge.lab.wire.messages import Header, Image
from fledge.world import Arena

INSTALL = "EGL (apt-get install libegl1 libgl1)"
"""What MuJoCo draws with on a machine without a screen."""
RATE = 30.0
"""[1/s] pictures at most; the AR.Drone's own cameras give as many (developer guide of SDK 2.0, chapter 7)."""
POLL = 0.002
"""[s] between two looks whether there are newer poses; chosen."""
PATIENCE = 0.1
"""[s] between two looks whether somebody subscribed; chosen."""
FRAME = "ardrone_base_bottomcam"
"""The frame of the camera, as ardrone_autonomy names it."""

Vehicles = Sequence[tuple[Vec3, Quat]]
Process = subprocess.Popen[bytes]


class Frame(NamedTuple):
    """A picture."""

    stamp: float
    """When it was taken [s], on the clock of whoever showed the poses."""
    width: int
    """[px]."""
    height: int
    """[px]."""
    pixels: bytes
    """Red, green, blue of each, row by row from the upper left; the top of the picture is the UAV's nose."""


class Pictures:
    """The bottom camera of a twin, for any number of viewers, each in a thread of its own."""

    def __init__(
        self,
        arena: Arena,
        airframe: Airframe = Airframe(),
        lens: Lens = Lens(),
        tell: Callable[[str], None] = print,
    ) -> None:
        """`tell` is told, once, why there are no pictures."""
        self._scene = mjcf(arena, airframe, lens).encode()
        self._size = round(lens.width_px), round(lens.height_px)
        self._tell = tell
        self._newest: tuple[float, Vehicles] | None = None
        self._lock = Lock()
        self._running: list[Process] = []
        self._over = False

    @property
    def watched(self) -> bool:
        """Whether anybody wants to see what `show` would show."""
        return bool(self._running)

    def show(self, stamp: float, vehicles: Vehicles) -> None:
        """What there is to be seen now: position [m] and world_from_body of all, the UAV first. Never waits."""
        self._newest = stamp, vehicles

    def frames(self) -> Generator[Frame]:
        """Pictures from now on, as they are taken; ends when there will be no more."""
        with self._process() as process:
            before, due = self._newest, time.monotonic()
            while process and not self._over:
                moment = self._newest
                if moment is None or moment is before:
                    time.sleep(POLL)
                    continue
                before, due = moment, max(due + 1.0 / RATE, time.monotonic())
                frame = self._developed(process, *moment)
                if frame:
                    yield frame
                time.sleep(max(due - time.monotonic(), 0.0))

    def close(self) -> None:
        """No more pictures, now."""
        with self._lock:
            self._over = True
            for process in self._running:
                process.kill()

    @contextmanager
    def _process(self) -> Iterator[Process | None]:
        """A darkroom at work, or none."""
        process = self._started()
        try:
            yield process if process and self._ready(process) else None
        finally:
            if process:
                self._ended(process)

    def _started(self) -> Process | None:
        width, height = map(str, self._size)
        surroundings = {"MUJOCO_GL": "egl"} | os.environ | darkroom.ALONE
        with self._lock:
            if self._over:
                return None
            process = subprocess.Popen(
                [sys.executable, "-P", "-m", darkroom.__name__, width, height],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=surroundings,
                start_new_session=True,  # Ctrl-C is for the twin
            )
            self._running.append(process)
            return process

    def _ready(self, process: Process) -> bool:
        """Whether it can draw; waits until that is known."""
        _sent(process, darkroom.LENGTH.pack(len(self._scene)) + self._scene)
        assert process.stdout
        line = process.stdout.readline().decode(errors="replace")
        if line != "\n":
            self._give_up(line.strip() or "the process that draws them has died")
        return not self._over

    def _developed(self, process: Process, stamp: float, vehicles: Vehicles) -> Frame | None:
        """The picture of a moment."""
        width, height = self._size
        size = width * height * darkroom.CHANNELS
        poses = chain.from_iterable((p.x, p.y, p.z, q.w, q.x, q.y, q.z) for p, q in vehicles)
        _sent(process, darkroom.POSES.pack(*poses))
        assert process.stdout
        pixels = process.stdout.read(size)
        if len(pixels) < size:
            self._give_up("the process that draws them has died")
            return None
        return Frame(stamp, width, height, pixels)

    def _give_up(self, why: str) -> None:
        with self._lock:
            if self._over:
                return
            self._over = True
        self._tell(
            f"no pictures of the bottom camera ({why}): valid is {INSTALL}, or another way in MUJOCO_GL"
        )

    def _ended(self, process: Process) -> None:
        with self._lock:
            self._running.remove(process)
        process.kill()
        for pipe in (process.stdin, process.stdout):
            assert pipe
            with suppress(BrokenPipeError):
                pipe.close()
        process.wait()


class Port(Protocol):
    """What a screening needs of ROS."""

    def listeners(self, topic: str) -> int:
        """How many hear it."""
        ...

    def send(self, datagram: Datagram) -> bool:
        """Whether it is on its way."""
        ...


@contextmanager
def screening(pictures: Pictures, port: Port) -> Iterator[Pictures]:
    """While this context lasts, whoever subscribes to the topic of pictures sees them."""
    end = Event()
    thread = Thread(target=_screen, args=(pictures, port, end), daemon=True, name="pictures")
    thread.start()
    try:
        yield pictures
    finally:
        end.set()
        pictures.close()
        thread.join()


def _screen(pictures: Pictures, port: Port, end: Event) -> None:
    numbers = count()
    while not end.wait(PATIENCE):
        if not port.listeners(topics.PICTURES):
            continue
        with closing(pictures.frames()) as frames:
            for frame in frames:
                port.send(_message(frame, next(numbers)))
                if not port.listeners(topics.PICTURES):
                    break


def _message(frame: Frame, number: int) -> Datagram:
    header = Header.at(max(frame.stamp, 0.0), FRAME, number)
    image = Image(header, frame.width, frame.height, frame.pixels)
    return Datagram(topics.PICTURES, topics.encode(image))


def _sent(process: Process, data: bytes) -> None:
    """To a process that may be dead: then there will be no answer, which is noticed where one is read."""
    assert process.stdin
    with suppress(BrokenPipeError):
        process.stdin.write(data)
        process.stdin.flush()
