"""Pilots: whoever turns an observation into an action. Add one: write one file."""

from fledge.pilots.base import AbstractPilot
from fledge.pilots.human_model import HumanModel
from fledge.pilots.servo import Servo

PILOTS = (HumanModel(), Servo())
"""The shipped pilots, for menus and for laws that every pilot must obey."""

__all__ = ["PILOTS", "AbstractPilot", "HumanModel", "Servo"]
