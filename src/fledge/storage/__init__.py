"""Storage: flights as MCAP, policies as ONNX, results as JSON, checkpoints as NPZ, arenas and contracts as TOML.

Whatever is written is whole, or not there.
"""

from fledge.storage.arenas import read_arena
from fledge.storage.atomic import replacing, sweep, write
from fledge.storage.checkpoints import read_checkpoint, write_checkpoint
from fledge.storage.contracts import read_contract, write_contract
from fledge.storage.flights import (
    FlightLog,
    list_flights,
    read_facts,
    read_flight,
    recover_flight,
    write_flight,
)
from fledge.storage.policies import read_policy, write_policy
from fledge.storage.results import read_json, write_json

__all__ = [
    "FlightLog",
    "list_flights",
    "read_arena",
    "read_checkpoint",
    "read_contract",
    "read_facts",
    "read_flight",
    "read_json",
    "read_policy",
    "recover_flight",
    "replacing",
    "sweep",
    "write",
    "write_checkpoint",
    "write_contract",
    "write_flight",
    "write_json",
    "write_policy",
]
