"""A training loop of one's own on the vector environment, in both modes of starting the next episode."""

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

import drillrig_env  # noqa: F401 - registers the environments

pytestmark = pytest.mark.clients
torch = pytest.importorskip("torch", reason="needs the extra clients")
MODES = [AutoresetMode.SAME_STEP, AutoresetMode.NEXT_STEP]


@pytest.mark.parametrize("mode", MODES, ids=lambda mode: mode.name)
def test_returns_are_finite_and_seeds_reproduce(mode):
    from tests.clients.ppo import Settings, train

    returns, agent = train(Settings(mode), duration=1.5)
    again, same = train(Settings(mode), duration=1.5)
    other, _ = train(Settings(mode, seed=1), duration=1.5)
    assert len(returns) == 4 * (96 // (15 if mode == AutoresetMode.SAME_STEP else 16))
    assert np.isfinite(returns).all()
    assert returns == again
    assert returns != other
    for name, parameter in agent.state_dict().items():
        assert torch.equal(parameter, same.state_dict()[name]), name
