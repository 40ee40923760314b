"""What an action stands for: the share of the slew limit at which the reference goes to where it is wanted."""

import numpy as np
import pytest

from drillrig_env.env.actions import rate_action


@pytest.mark.parametrize(
    ("wanted", "reference", "slew_limit", "action"),
    [(4.0, 3.9, 2.0, 0.5), (3.9, 4.0, 2.0, -0.5), (4.0, 3.9, 1.0, 1.0), (9.0, 1.0, 2.0, 1.0), (0.0, 5.0, 2.0, -1.0)],
)
def test_action_takes_the_reference_there_within_a_control_step_if_the_slew_limit_lets_it(
    wanted, reference, slew_limit, action
):
    found = rate_action(np.array([wanted]), np.array([reference]), slew_limit)
    assert found.dtype == np.float32
    assert found.shape == (1, 1)
    assert found[0, 0] == pytest.approx(action, abs=1e-6)
