"""Pilots: whoever turns an observation into an action. Add one: write one file."""

from fledge.pilots.base import AbstractPilot
from fledge.pilots.exciter import Exciter
from fledge.pilots.human_model import HumanModel
from fledge.pilots.servo import Servo

PILOTS = (Exciter(), HumanModel(), Servo())
"""The shipped pilots, for menus and for laws that every pilot must obey."""
FOLLOWERS = tuple(pilot for pilot in PILOTS if not isinstance(pilot, Exciter))
"""Those of them who keep the UGVs where they should be in the picture."""

__all__ = ["FOLLOWERS", "PILOTS", "AbstractPilot", "Exciter", "HumanModel", "Servo"]
