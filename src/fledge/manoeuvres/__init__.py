"""Manoeuvres: what the UGVs do while the UAV keeps them in view. Add one: write one file."""

from fledge.manoeuvres.base import AbstractManoeuvre, FormationTrack, Plan
from fledge.manoeuvres.climb import Climb
from fledge.manoeuvres.combined import Combined
from fledge.manoeuvres.descend import Descend
from fledge.manoeuvres.fixed_altitude import FixedAltitude

MANOEUVRES = (FixedAltitude(), Climb(), Descend(), Combined())
"""The paper's four, for menus and for laws that every manoeuvre must obey."""

__all__ = [
    "MANOEUVRES",
    "AbstractManoeuvre",
    "Climb",
    "Combined",
    "Descend",
    "FixedAltitude",
    "FormationTrack",
    "Plan",
]
