"""The laws of the house: which module may import which, and what the core may not touch.

The order of imports is written once, in `LAYERS`, and read off the source itself: imports inside functions count too,
those under `if TYPE_CHECKING` do not.
"""

import ast
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

SRC = Path(__file__).parents[1] / "src" / "fledge"
TESTS = Path(__file__).parent

LAYERS = (
    ("__init__",),
    ("cli",),
    ("commands",),
    ("cockpit",),
    ("runs",),
    ("lookup", "console"),
    ("guests", "report"),
    ("lab.outing",),
    ("lab.lockstep",),
    ("lab.shell", "lab.survey"),
    ("storage",),
    ("faults",),
    ("falsification",),
    ("study",),
    ("learning",),
    ("engines",),
    ("simulation",),
    ("pytrees", "cores"),
    ("lab.control", "lab.twin"),
    ("lab.opening", "lab.wire"),
    ("formation",),
    ("supervision", "conditions"),
    ("manoeuvres", "pilots", "safety"),
    ("episode",),
    ("observation", "clearance", "lab"),
    ("camera", "dynamics"),
    ("room",),
    ("world",),
    ("geometry",),
    ("scalars",),
    ("errors",),
)
"""From top to bottom: a module imports only what stands below it. Neighbours in one layer are strangers. A room is one
name; its files import each other, without cycles. A new module or room takes its place here."""

DEPTH = {name: depth for depth, layer in enumerate(LAYERS) for name in layer}

SHELL = {
    *("cli", "commands", "runs", "lookup", "guests", "console", "report", "storage"),
    *("lab.shell", "lab.twin.picture", "lab.twin.darkroom"),
    *("cockpit.tape", "cockpit.deck", "cockpit.meters", "cockpit.usher", "cockpit.stock", "cockpit.shelf"),
    *(
        "cockpit.school",
        "cockpit.sortie",
        "cockpit.attached",
        "cockpit.twinned",
        "cockpit.guard",
        "cockpit.site",
        "cockpit.server",
    ),
}
"""Files, clocks and terminals live here, and nowhere else."""

MAY_USE_JAX = {
    *("simulation", "engines", "pytrees", "falsification", "study", "cli"),
    *("cockpit.flight", "cockpit.screen", "cockpit.twinned", "cockpit.shelf", "cockpit.stock"),
    *("cockpit.deck", "cockpit.site", "cockpit.server"),
    *(
        "learning.demonstrations",
        "learning.fusion",
        "learning.split",
        "learning.takeovers",
        "learning.training",
    ),
    *("faults.drills", "faults.injection", "storage.checkpoints", "storage.results"),
    *("commands.study", "commands.lab_study", "commands.doctor", "report.study"),
    *("runs.logbook", "runs.apprenticeship", "runs.archive", "runs.evidence", "runs.labwork"),
}
"""The simulator and what stands on it. All else serves a lab without JAX: everything below the simulator, and the way
from a file to a flying policy."""

IMPURE_MODULES = {
    *("asyncio", "socket", "subprocess", "threading", "multiprocessing"),
    *("datetime", "time"),
    *("logging", "os", "pathlib", "shutil", "tempfile"),
    *("random", "secrets", "uuid"),
}
CORES = {("cores", "os"), ("pytrees", "threading")}
"""Flights and networks share the machine's cores, threads the register of records: that is no effect."""
IMPURE_CALLS = {"input", "open", "print"}
SEEDED = {"BitGenerator", "Generator", "PCG64", "Philox", "SeedSequence", "default_rng"}
"""What the core may take from `numpy.random`; the rest is global, or unseeded."""

EMPTY_NAMES = {"common", "helpers", "misc", "util", "utils"}


class Imports(ast.NodeVisitor):
    """Collects `(dotted name, line)` of everything imported at run time."""

    def __init__(self) -> None:
        self.found: list[tuple[str, int]] = []

    def visit_Import(self, node: ast.Import) -> None:
        self.found += [(alias.name, node.lineno) for alias in node.names]

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        assert node.level == 0, f"line {node.lineno}: imports are absolute"
        self.found += [(f"{node.module}.{alias.name}", node.lineno) for alias in node.names]

    def visit_If(self, node: ast.If) -> None:
        unseen = ast.unparse(node.test) in ("TYPE_CHECKING", "typing.TYPE_CHECKING")
        for child in node.orelse if unseen else ast.iter_child_nodes(node):
            self.visit(child)


@cache
def modules() -> dict[str, ast.Module]:
    """The source of every module, by its name without `fledge.`; a folder's `__init__` bears the folder's name."""
    trees = {}
    for path in sorted(SRC.rglob("*.py")):
        parts = path.relative_to(SRC).with_suffix("").parts
        name = ".".join(parts[:-1] if len(parts) > 1 and parts[-1] == "__init__" else parts)
        trees[name] = ast.parse(path.read_text(), filename=str(path))
    return trees


def imports(name: str) -> Iterator[tuple[str, int]]:
    """What a module imports, in full, and on which line."""
    visitor = Imports()
    visitor.visit(modules()[name])
    yield from visitor.found


def inner_imports(name: str) -> Iterator[tuple[str, int]]:
    """The modules of fledge that a module imports, and on which line."""
    for imported, line in imports(name):
        root, *parts = imported.split(".")
        if root == "fledge":
            while parts and ".".join(parts) not in modules():
                parts.pop()
            yield ".".join(parts) or "__init__", line


def outer_imports(name: str) -> Iterator[tuple[str, int]]:
    """The packages other than fledge that a module imports, and on which line."""
    for imported, line in imports(name):
        root = imported.split(".")[0]
        if root != "fledge":
            yield root, line


def room(name: str) -> str:
    """What stands for a module in `LAYERS`: its own name if that is there, else the room's that it is in."""
    while name not in DEPTH and "." in name:
        name = name.rpartition(".")[0]
    return name


def core() -> list[str]:
    return [name for name in modules() if not {name, room(name)} & SHELL]


def without_jax() -> list[str]:
    return [name for name in modules() if not {name, room(name)} & MAY_USE_JAX]


def loaded_after(statement: str) -> set[str]:
    """Top-level packages that a fresh interpreter has loaded after `statement`."""
    code = f"{statement}; import sys; print(*{{m.split('.')[0] for m in sys.modules}})"
    fresh = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(fresh.stdout.split())


@pytest.mark.slow
def test_every_module_has_its_place() -> None:
    homeless = {name for name in modules() if room(name) not in DEPTH}
    assert not homeless, f"give these a place in LAYERS: {sorted(homeless)}"


def test_every_place_has_its_module() -> None:
    empty = set(DEPTH) - {room(name) for name in modules()}
    assert not empty, f"LAYERS names what does not exist: {sorted(empty)}"


def test_imports_go_down() -> None:
    wrong = [
        f"{name} imports {other} (line {line})"
        for name in modules()
        for other, line in inner_imports(name)
        if room(name) != room(other) and DEPTH[room(name)] >= DEPTH[room(other)]
    ]
    assert not wrong


def test_no_module_imports_itself_in_the_end() -> None:
    TopologicalSorter({name: {other for other, _ in inner_imports(name)} for name in modules()}).prepare()


def test_the_net_can_be_reviewed_alone() -> None:
    allowed = {"errors", "scalars", "geometry", "world", "dynamics", "safety"}
    seen = {room(other) for name in modules() if room(name) == "safety" for other, _ in inner_imports(name)}
    assert seen <= allowed


def test_statistics_know_nothing_of_drones() -> None:
    assert {other for other, _ in inner_imports("study.statistics")} <= {"errors"}


@pytest.mark.slow
def test_the_lab_needs_no_jax() -> None:
    wrong = [
        f"{name} imports {package} (line {line})"
        for name in without_jax()
        for package, line in outer_imports(name)
        if package in ("jax", "jaxlib", "optax")
    ]
    assert not wrong
    everything = ", ".join(f"fledge.{name}" for name in without_jax() if name != "__init__")
    loaded = loaded_after(f"import {everything}") & {"jax"}
    assert not loaded, "a module on the lab's way loads jax; a folder's __init__ that imports too much, say"


def test_importing_fledge_is_light() -> None:
    assert not loaded_after("import fledge") & {"jax", "matplotlib", "scipy"}


def test_the_core_is_pure() -> None:
    wrong = [
        f"{name} imports {package} (line {line})"
        for name in core()
        for package, line in outer_imports(name)
        if package in IMPURE_MODULES and (name, package) not in CORES
    ]
    for name in core():
        for node in ast.walk(modules()[name]):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in IMPURE_CALLS:
                wrong.append(f"{name} calls {ast.unparse(node.func)} (line {node.lineno})")
    assert not wrong


def test_the_core_takes_its_chance_from_a_seed() -> None:
    wrong = []
    for name in core():
        for node in ast.walk(modules()[name]):
            if isinstance(node, ast.Attribute) and ast.unparse(node.value) in ("np.random", "numpy.random"):
                if node.attr not in SEEDED:
                    wrong.append(f"{name} uses {ast.unparse(node)} (line {node.lineno})")
            if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("random.default_rng"):
                if not node.args and not node.keywords:
                    wrong.append(f"{name} draws an unseeded generator (line {node.lineno})")
    assert not wrong


def test_no_module_is_called_nothing() -> None:
    assert not {name for name in modules() if EMPTY_NAMES & set(name.split("."))}


def test_every_module_has_its_test() -> None:
    expected = {
        path.relative_to(SRC).with_name(f"test_{path.name}")
        for path in SRC.rglob("*.py")
        if path.name not in ("__init__.py", "base.py")
    }
    missing = [str(path) for path in sorted(expected) if not (TESTS / path).exists()]
    assert not missing, f"write tests/: {missing}"
