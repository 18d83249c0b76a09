"""Safety nets: what stands between a pilot and a vehicle. Add one: write one file."""

from fledge.safety.base import AbstractNet
from fledge.safety.none import NoNet

NETS = (NoNet(),)
"""The shipped nets, for menus and for laws that every net must obey."""

__all__ = ["NETS", "AbstractNet", "NoNet"]
