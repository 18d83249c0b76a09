"""All that a net relies on, as one record."""

from dataclasses import replace

import pytest

from fledge.safety import NETS, Barrier, Conformal, Contract, StopTube, UavStop
from fledge.safety.terms import Terms

OTHER = Terms(Contract(latency=0.03), UavStop(error=0.2), Terms().ugvs[:2])


@pytest.mark.parametrize("net", [StopTube(scale=0.9), Barrier(pace=0.5)])
def test_a_net_relies_on_them_and_keeps_everything_else(net):
    assert OTHER.under(net) == replace(net, contract=OTHER.contract, uav=OTHER.uav, ugvs=OTHER.ugvs)


def test_what_was_learnt_comes_on_top():
    net = OTHER.under(Conformal())
    assert isinstance(net, Conformal) and net.proven.uav == OTHER.uav and net.overruns == Conformal().overruns


@pytest.mark.parametrize("net", NETS, ids=lambda net: type(net).__name__)
def test_by_default_they_are_what_nets_rely_on_anyway(net):
    assert Terms().under(net) == net
