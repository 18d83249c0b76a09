"""Delete each clause of the stop-tube nets, one at a time, and see that a test fails: `make mutations`.

A clause is a line of the proof: a term of the margin, a condition under which a command may pass, an error that is
counted. The table of the supervisor is mutated row by row in `tests/supervision/test_modes.py`.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).parents[1]
TESTS = [f"tests/safety/test_{name}.py" for name in ("tube", "stop_tube", "barrier", "contract", "turns")]

CLAUSES: dict[str, list[tuple[str, str]]] = {
    "tube": [
        # The UAV's stop.
        ("forward = stop.speed * forward", "forward = 0.0 * forward"),
        ("left = stop.speed * left", "left = 0.0 * left"),
        ("up = stop.speed_up * uav.velocity.z", "up = 0.0 * uav.velocity.z"),
        ("+ stop.followed * follow_forward", "+ 0.0 * follow_forward"),
        ("dx + T * x", "dx"),
        ("dy + T * y", "dy"),
        ("up + stop.followed_up * fz + T * z", "up"),
        ("contract.position_error + maximum(stop.hold, side)", "contract.position_error"),
        ("contract.position_error + maximum(stop.hold, side)", "maximum(stop.hold, side)"),
        ("contract.position_error + max(stop.hold, height)", "contract.position_error"),
        ("rest(since + lag))", "rest(since))"),
        ("side + stop.rate * contract.rate_error + uav_miss(stop, uav, pace)", "side"),
        ("stop.miss(moving.speed, moving.turn)", "stop.miss(moving.speed, 0.0)"),
        ("pace.then(uav.velocity.x, uav.velocity.y, 0.0)", "pace"),
        (
            "pace.then(uav.velocity.x, uav.velocity.y, 0.0)",
            "Pace(0.0, pace.turn).then(uav.velocity.x, uav.velocity.y, 0.0)",
        ),
        ("maximum(self.speed * left, speed)", "speed"),
        ("maximum(self.turn * left, abs(turn))", "abs(turn)"),
        # The UGV's stop.
        ("age + contract.latency + contract.period", "0.0 * age"),
        ("speed = seen + error", "speed = seen"),
        ("maximum(maximum(speed, minimum(sent.most, speed + gain * reaction)), 0.0)", "maximum(speed, 0.0)"),
        ("speed * self.reaction, maximum(way, 0.0),", "0.0 * speed, maximum(way, 0.0),"),
        ("speed * self.reaction, maximum(way, 0.0),", "speed * self.reaction, 0.0 * way,"),
        ("top * top / (2.0 * brake)", "0.0 * top"),
        ("self.stop.acceleration - self.contract.disturbance", "self.stop.acceleration"),
        ("Turn(error + left.whole, error + right.whole)", "Turn(0.0, 0.0)"),
        ("(left, right), (right, left)", "(left, right), (left, right)"),
        ("clip(towards + aside * nose, 0.0, 1.0)", "clip(towards, 0.0, 1.0)"),
        ("clip(aside * tail - towards, 0.0, 1.0)", "clip(-towards, 0.0, 1.0)"),
        ("speed * self.reaction + told", "told"),
        ("+ told * self.stop.hold_over", ""),
        ("(speed * speed + told * told)", "(speed * speed)"),
        ("(speed * speed + told * told)", "(told * told)"),
        # How far it turns from what it is committed to.
        ("0.5 * self.reacting * turn.reacting + self.held", "self.held"),
        ("self.held * (turn.reacting + growing)", "self.held * growing"),
        ("self.held * (turn.reacting + growing)", "self.held * turn.reacting"),
        ("self.braking * turn.whole", "self.braking * turn.reacting"),
        ("steady = 0.5 * told * self.stop.hold_over", "steady = 0.0"),
        (" + eased * eased / (2.0 * self.stop.turn_acceleration)", ""),
        ("Phases(top, speed * self.reaction", "Phases(told, speed * self.reaction"),
        ("error + way.turned(left, growing_left)", "0.0 * error"),
        ("error + way.turned(right, growing_right)", "0.0 * error"),
        ("maximum(towards, 0.0) + aside * ahead", "towards + aside * ahead"),
        ("maximum(-towards, 0.0) + aside * astern", "aside * astern - towards"),
        ("(self.ahead.right, self.astern.left)", "(self.ahead.left, self.astern.right)"),
        # What may still be gone on with.
        ("(self.newer, none, lasts)", "(none, none, lasts)"),
        ("(self.newer, none, lasts)", "(self.newer, none, left)"),
        (
            "maximum(self.most * maximum(self.left - delay, 0.0), self.newer * hold_over)",
            "self.newer * hold_over",
        ),
        (
            "maximum(self.most * maximum(self.left - delay, 0.0), self.newer * hold_over)",
            "self.most * maximum(self.left - delay, 0.0)",
        ),
        ("maximum(newer, command)", "command"),
        ("instead = command * hold_over - missed", "instead = command * hold_over"),
        ("maximum(least.x * x, most.x * x)", "0.0"),
        ("maximum(least.y * y, most.y * y)", "0.0"),
        ("self.tube.sink() - self.least.z", "self.tube.sink()"),
        # What must be stayed clear of.
        ("(1.0, 0.0, x - b.x_min - radius)", "(1.0, 0.0, x - b.x_min)"),
        ("(-1.0, 0.0, b.x_max - x - radius)", "(-1.0, 0.0, 1e3 + 0.0 * x)"),
        ("(0.0, 1.0, y - b.y_min - radius)", "(0.0, 1.0, 1e3 + 0.0 * y)"),
        ("(0.0, -1.0, b.y_max - y - radius)", "(0.0, -1.0, 1e3 + 0.0 * y)"),
        ("low - sink, Reason.FLOOR", "low + 1e3, Reason.FLOOR"),
        ("high - tube.error_up - tube.rise()", "high - tube.error_up + 1e3"),
        ("above - sink, Reason.OBSTACLE", "above + 1e3, Reason.OBSTACLE"),
        ("above - sink, Reason.VEHICLE", "above + 1e3, Reason.VEHICLE"),
        ("return gap - tube.error - tube.advance(-nx, -ny)", "return gap - tube.error"),
        ("return gap - tube.error - tube.advance(-nx, -ny)", "return gap - tube.advance(-nx, -ny)"),
        ("contract.position_error - one.sweep.advance(nx, ny)", "contract.position_error"),
        ("surely(room_above >= gap)", "surely(room_above >= 0.0)"),
        ("room = gap - 2.0 * error", "room = gap + 1e3"),
        ("room - way, Reason.VEHICLE", "room, Reason.VEHICLE"),
        ("surely(one[0] - error > reach)", "surely(one[0] > 0.5 * reach)"),
        ("surely((gap > reach) & (gap < inf))", "surely(gap > reach)"),
        ("beyond(room - other.reach, reach)", "beyond(room, reach)"),
        ("beyond(room - other.reach, reach)", "beyond(room, other.reach)"),
        ("motion.reach(maximum(sent.ahead.most, sent.astern.most))", "motion.reach(sent.ahead.most)"),
        ("where(motion.known, motion.reach(", "where(True, motion.reach("),
        ("return self.error + reduce(maximum,", "return 0.0 * self.error + reduce(maximum,"),
        ("far = reach + tube.reach", "far = reach + tube.error"),
        ("gap - contract.position_error - one.reach, far", "gap, far"),
        ("not surely(face.room > reach)", "not surely(face.room > 0.5 * reach)"),
        ("commitment.sink() >= 0.0", "commitment.sink() >= -1e3"),
        ("above - commitment.tube.error_up - commitment.sink()", "above - commitment.sink()"),
    ],
    "turns": [
        ("(age >= -contract.period) & ", ""),
        (" & (age <= contract.age + 0.5 * contract.period)", ""),
        ("known = number & fresh & _whole(world.uav)", "known = fresh & _whole(world.uav)"),
        ("known = number & fresh & _whole(world.uav)", "known = number & _whole(world.uav)"),
        ("known = number & fresh & _whole(world.uav)", "known = number & fresh"),
        ("then(velocity.x, velocity.y, sent.turn, fades)", "then(zero, zero, sent.turn, fades)"),
        ("then(velocity.x, velocity.y, sent.turn, fades)", "then(velocity.x, velocity.y, zero, fades)"),
        ("face.closer(more * (1.0 - face.z * face.z))", "face"),
        ("tube._replace(error=uav_error(net.contract, stop, world.uav, pace))", "tube"),
        ("share = minimum(1.0, stop.most /", "share = minimum(1.0, 1e3 * stop.most /"),
        ("known = number & fresh & motion.known", "known = fresh & motion.known"),
        ("known = number & fresh & motion.known", "known = number & motion.known"),
        ("known = number & fresh & motion.known", "known = number & fresh"),
        ("passes = passes & isfinite(chosen)", "passes = passes"),
        ("where(holding, ahead * PULL, Vec3(zero, zero, zero))", "Vec3(zero, zero, zero)"),
        ("(already | slow | tight)", "(already | slow)"),
        ("step = where(tight, RETREAT * contract.period, 0.0)", "step = 0.0"),
        ("cond(may_turn, lambda: turning, lambda: swept(0.0 * turn))", "turning"),
        ("stands | clear(turning[2])", "clear(turning[2])"),
        ("turned = where(passes | stands, turn, zero)", "turned = where(passes, turn, zero)"),
        ("turned = where(passes | stands, turn, zero)", "turned = turn"),
        (
            "UavCommitment.of(tube, axes, net.contract.period, stop.hold_over)",
            "UavCommitment.of(tube, axes, 0.0, 0.0)",
        ),
        ("where(age <= 2.0 * net.contract.age, 0.0 * age, FREE)", "0.0 * age"),
        (
            "UgvCommitment(UgvMotion.of(net.contract, stop, ugv, sent,",
            "UgvCommitment(UgvMotion.of(net.contract, stop, ugv, memory.ugvs[i],",
        ),
        ("clip(proposed.forward, -stop.most, stop.most), clip", "proposed.forward, clip"),
        ("cond(face.room > reach,", "cond(face.room > 0.5 * reach,"),
        ("AHEAD * net.uav.most", "0.0 * net.uav.most"),
        ("minimum(abs(proposed.forward), stop.most)", "minimum(proposed.forward, stop.most)"),
        ("minimum(abs(proposed.forward), stop.most)", "0.0"),
        ("stop.most)) + net.reserve", "stop.most))"),
    ],
    "stop_tube": [
        ("lambda: True, partial(self._clears, face, turn.proposal)", "lambda: True, lambda: True"),
        ("minimum(away, 0.0) * self.uav.hold_over", "0.0"),
        ("((room < 0.0) & (away >= self.outwards))", "((room < 0.0) & (away >= 0.0))"),
        ("((room < 0.0) & (away >= self.outwards))", "(room < -1e6)"),
        ("(left >= 0.0) | ", "(left >= -1e6) | "),
        ("(room >= 0.0) | ", "(room >= -1e6) | "),
        ("(nearer <= 0.0)", "(room < -1e6)"),
        ("(nearer <= 0.0)", "(nearer <= 1e6)"),
        ("c, passes = turn.wanted, turn.known", "c, passes = turn.wanted, True"),
        ("turn.known & cond(", "cond("),
        ("partial(self._may_go, turn, rooms)", "lambda: True"),
    ],
    "barrier": [
        ("minimum(-face.room / self.pace, RETREAT)", "-1e3 + 0.0 * face.room"),
        ("low = maximum(low, where(face.z > 0.5, least, -self.uav.most_up))", "pass"),
        ("high = minimum(high, where(face.z < -0.5, -least, self.uav.most_up))", "pass"),
        ("kept = kept & (plane.lacks(x, y) <= TINY)", "pass"),
        ("return turn.known & kept", "return kept"),
        ("fastest = minimum(fastest, self._speed(room, forwards, stop))", "pass"),
        ("slowest = maximum(slowest, -self._speed(room, backwards, stop))", "pass"),
        ("return turn.known, clip", "return True, clip"),
        ("room - self.reserve * share", "room"),
        ("where(share <= TINY, FREE,", "where(share <= -1.0, FREE,"),
        ("where(share <= TINY, FREE,", "where((share <= TINY) | (share != share), FREE,"),
        ("inside = inside & (plane.lacks(cx, cy) <= TINY)", "pass"),
        ("better = inside & (far < best)", "better = inside"),
    ],
}


def survives(module: str, old: str, new: str) -> bool:
    """Whether every test passes without the clause."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "src", Path(folder) / "src")
        path = Path(folder) / "src" / "fledge" / "safety" / f"{module}.py"
        source = path.read_text()
        assert source.count(old) == 1, f"{module}: {source.count(old)} times: {old}"
        path.write_text(source.replace(old, new))
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *TESTS]
        path_first = {**os.environ, "PYTHONPATH": str(Path(folder) / "src")}
        return subprocess.run(command, cwd=ROOT, env=path_first, capture_output=True).returncode == 0


def main() -> None:
    """Mutate all, or the modules named on the command line."""
    chosen = sys.argv[1:] or list(CLAUSES)
    mutants = [(module, old, new) for module in chosen for old, new in CLAUSES[module]]
    survived = 0
    with ThreadPoolExecutor(2) as pool:
        results = pool.map(lambda mutant: survives(*mutant), mutants)
        for (module, old, new), alive in zip(mutants, results, strict=True):
            survived += alive
            print(f"{'SURVIVED' if alive else 'caught':8}  {module}: {old!r} -> {new!r}", flush=True)
    print(f"{len(mutants) - survived} of {len(mutants)} caught")
    sys.exit(survived > 0)


if __name__ == "__main__":
    main()
