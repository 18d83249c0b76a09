"""Storage: flights as MCAP, policies as ONNX, results as JSON, checkpoints as NPZ, whole or not there; arenas."""

from fledge.storage.arenas import read_arena
from fledge.storage.atomic import replacing, sweep, write
from fledge.storage.checkpoints import read_checkpoint, write_checkpoint
from fledge.storage.flights import FlightLog, list_flights, read_flight, write_flight
from fledge.storage.policies import read_policy, write_policy
from fledge.storage.results import read_json, write_json

__all__ = [
    "FlightLog",
    "list_flights",
    "read_arena",
    "read_checkpoint",
    "read_flight",
    "read_json",
    "read_policy",
    "replacing",
    "sweep",
    "write",
    "write_checkpoint",
    "write_flight",
    "write_json",
    "write_policy",
]
