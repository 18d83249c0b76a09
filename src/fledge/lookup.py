"""From a name on the command line to what it names.

A pilot, a manoeuvre or a net is named by its module (`servo` is `fledge/pilots/servo.py`, `fixed-altitude` is
`fledge/manoeuvres/fixed_altitude.py`), or as `package.module:Name` from anywhere Python can import, the current
folder included (see `guests`). There is no registry: whatever has the right base class will do. Who flies in an
evaluation may be a policy's file, too. An arena is named by its file, and those in `fledge/arenas/` by its stem; so is
the contract of a lab's net, in `fledge/contracts/`.
"""

import pkgutil
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fledge import guests
from fledge.errors import BadFile, FledgeError, UnknownName

if TYPE_CHECKING:
    from fledge.learning.policy import Policy
    from fledge.manoeuvres import AbstractManoeuvre
    from fledge.pilots import AbstractPilot
    from fledge.safety import AbstractNet
    from fledge.study.setups import Setup
    from fledge.world import Arena

ARENAS = {path.stem: path for path in Path(__file__).with_name("arenas").glob("*.toml")}
"""The arenas that fledge brings along."""
CONTRACTS = {path.stem: path for path in Path(__file__).with_name("contracts").glob("*.toml")}
"""The contracts of safety nets that fledge brings along."""
LAB_CONTRACT = "ar-drone-2"
"""The twin's; what `fledge fly` relies on unless it is told otherwise."""


def pilot(name: str) -> "AbstractPilot":
    """The pilot of that name.

    Raises:
        FledgeError: there is none, or it is none.
    """
    from fledge.pilots import AbstractPilot

    return find("fledge.pilots", AbstractPilot, name, guests.pilot)


def manoeuvre(name: str) -> "AbstractManoeuvre":
    """The manoeuvre of that name, as it is demonstrated.

    Raises:
        FledgeError: there is none, or it is none.
    """
    from fledge.manoeuvres import AbstractManoeuvre

    return find("fledge.manoeuvres", AbstractManoeuvre, name, guests.manoeuvre)


def test(name: str) -> "AbstractManoeuvre":
    """The manoeuvre of that name, as it is tested: the paper's four along paths that no demonstration used.

    Raises:
        FledgeError: there is none, or it is none.
    """
    from fledge.study.setups import TEST_MANOEUVRES

    declared = {one.name: one for one in TEST_MANOEUVRES}
    return declared.get(name) or manoeuvre(name)


def net(name: str) -> "AbstractNet":
    """The safety net of that name.

    Raises:
        FledgeError: there is none, or it is none.
    """
    from fledge.safety import AbstractNet

    return find("fledge.safety", AbstractNet, name, guests.net)


def lab_net(name: str, contract: str = LAB_CONTRACT) -> "AbstractNet":
    """The safety net of that name, relying on a lab's contract: one by its name, or its file.

    Raises:
        FledgeError: there is none, or it is none.
    """
    from fledge.storage import read_contract

    return read_contract(contract_file(contract)).under(net(name))


def setup(name: str) -> "Setup":
    """The set-up of that name, of those that train once on demonstrations as they are stored.

    Raises:
        UnknownName: there is none.
    """
    from fledge.study.setups import BASIC, FURTHER

    known = {one.name: one for one in BASIC + FURTHER if one.trained_on and not (one.rows or one.seeds)}
    if name not in known:
        raise UnknownName("set-up", name, known)
    return known[name]


def contestant(name: str) -> "AbstractPilot":
    """Who flies in an evaluation: the policy in a file of that name, or else the pilot.

    Raises:
        FledgeError: there is neither, or the policy was not trained for this vehicle.
    """
    path = Path(name)
    if path.suffix == ".onnx" or path.is_file():
        return policy(path)
    try:
        return pilot(name)
    except UnknownName as error:
        raise FledgeError(f"{error}, or a policy's file") from error


def policy(path: Path) -> "Policy":
    """The policy in a file.

    Raises:
        BadFile: it cannot be read, or was not trained for this vehicle.
    """
    from fledge.learning.policy import Contract
    from fledge.storage import read_policy

    policy = read_policy(path)
    if policy.contract is None:
        raise BadFile(path, "a policy without a contract: it was not trained to fly")
    try:
        policy.contract.check(Contract())
    except FledgeError as error:
        raise BadFile(path, str(error)) from error
    return replace(policy, contract=None)  # it names the data: left in, every policy would be compiled anew


def arena(name: str) -> "Arena":
    """The arena of that name, or else the one in a file.

    Raises:
        UnknownName: there is neither.
        BadFile: the file holds no arena.
    """
    from fledge.storage import read_arena

    path = ARENAS.get(name, Path(name))
    if path.suffix != ".toml" and not path.is_file():
        raise UnknownName("arena", name, [*ARENAS, "FILE.toml"])
    return read_arena(path)


def contract_file(name: str) -> Path:
    """The file of the contract of that name, or else the file itself.

    Raises:
        UnknownName: there is neither.
    """
    path = CONTRACTS.get(name, Path(name))
    if path.suffix != ".toml" and not path.is_file():
        raise UnknownName("contract", name, [*CONTRACTS, "FILE.toml"])
    return path


def find(folder: str, base: type, name: str, guest: Callable[[str], Any]) -> Any:
    """What is called `name` in a package of fledge's, "fledge.pilots" say; `guest` fetches those from outside.

    Raises:
        UnknownName: there is none; lists those that exist.
    """
    if ":" in name:
        return guest(name)
    known = shipped(folder, base)
    if name not in known:
        kind = base.__name__.removeprefix("Abstract").lower()
        raise UnknownName(kind, name, [*known, "package.module:Name"])
    return known[name]()


def shipped(folder: str, base: type) -> dict[str, type]:
    """The classes of a kind in a package of fledge's, each by the name of its module."""
    names = [module.name for module in pkgutil.iter_modules(import_module(folder).__path__)]
    modules = {name.replace("_", "-"): import_module(f"{folder}.{name}") for name in names}
    return {name: kind for name, module in modules.items() for kind in guests.kinds(module, base)}
