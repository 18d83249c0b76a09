"""All that a net relies on in one lab, as one record: the contract, and how each of its vehicles stops.

`fledge identify` finds it out from flights, `storage.contracts` keeps it, and a net is built on it. Nets that predict
no stop, the paper's say, have no use for it and stay as they are.
"""

from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

from fledge.dynamics import UGV_FLEET
from fledge.safety.base import AbstractNet
from fledge.safety.contract import Contract, UavStop, UgvStop


@dataclass(frozen=True, slots=True)
class Terms:
    """What holds in a lab; by default, in the simulated one."""

    contract: Contract = Contract()
    uav: UavStop = UavStop()
    ugvs: tuple[UgvStop, ...] = tuple(UgvStop.of(model) for model in UGV_FLEET)

    def under(self, net: AbstractNet) -> AbstractNet:
        """The net, relying on this instead."""
        has = {field.name for field in fields(net)} if is_dataclass(net) else set()
        known: Any = net
        if {"contract", "uav", "ugvs"} <= has:
            return replace(known, contract=self.contract, uav=self.uav, ugvs=self.ugvs)
        if "proven" in has:
            return replace(known, proven=self.under(known.proven))
        return net
