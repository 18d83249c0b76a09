"""Safety nets: what stands between a pilot and a vehicle. Add one: write one file."""

from fledge.safety.barrier import Barrier
from fledge.safety.base import AbstractNet, Halt
from fledge.safety.conformal import Conformal, Overruns
from fledge.safety.contract import Contract, UavStop, UgvStop
from fledge.safety.none import NoNet
from fledge.safety.paper import PaperNet
from fledge.safety.paper_repaired import RepairedPaperNet
from fledge.safety.stop_tube import StopTube

NETS = (NoNet(), PaperNet(), RepairedPaperNet(), StopTube(), Conformal(), Barrier())
"""The shipped nets, for menus and for laws that every net must obey."""

__all__ = [
    "NETS",
    "AbstractNet",
    "Barrier",
    "Conformal",
    "Contract",
    "Halt",
    "NoNet",
    "Overruns",
    "PaperNet",
    "RepairedPaperNet",
    "StopTube",
    "UavStop",
    "UgvStop",
]
