"""Records in JAX's eyes."""

import jax
import pytest

from fledge.pytrees import register
from fledge.safety import NETS


@pytest.mark.parametrize("net", NETS, ids=lambda net: type(net).__name__)
def test_a_net_is_a_constant_to_the_compiler(net):
    """Its numbers decide how much it remembers, and which way it goes."""
    register(net)
    assert jax.tree.leaves(net) == []
