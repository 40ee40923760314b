"""Landing within a step, by the series and by the rungs below."""

import numpy as np
import pytest

from drillrig_env import Rig
from drillrig_env.model import friction_input, jacobian
from drillrig_env.stepper.exponentials import RADAU_NODES, variation_of_constants
from drillrig_env.stepper.ladder import RUNGS
from drillrig_env.stepper.landing import land
from drillrig_env.stepper.tables import step_tables
from drillrig_env.stepper.workspace import workspace

START = np.array([-0.3, -1.1, 1.5, 2.0, 2.5, 0.4, 0.2, 0.0])


@pytest.mark.parametrize("rig", [Rig(), Rig(L=3e-6), Rig(R=3.0, L=4e-9), Rig(J_2=1e-7), Rig(d_1=3e3), Rig(k_1=1e7)])
@pytest.mark.parametrize("share", [0.013, 0.37, 0.985, 1.0])
def test_landing_is_the_step_of_that_length(rig, share):
    tables, work, y = step_tables(rig, 0.09), workspace()[0], START.copy()
    work["torque"] = 0.4 - 0.7 * RADAU_NODES + 0.9 * RADAU_NODES**3
    assert land(y, tables.ladders[0], 5, work, share)
    from_state, from_torque = variation_of_constants(jacobian(rig), friction_input(rig), share * 0.09 / 32, RADAU_NODES)
    s = share * RADAU_NODES
    expected = from_state[0, -1] @ START[:7] + from_torque[0, -1] @ (0.4 - 0.7 * s + 0.9 * s**3)
    np.testing.assert_allclose(y[:5], expected[:5], atol=1e-11)
    np.testing.assert_allclose(y[6], expected[6], atol=1e-11)


def test_nothing_is_followed_where_no_rung_is_short_enough():
    ladders = step_tables(Rig(), 0.1).ladders.copy()
    ladders["series_from"] = RUNGS
    assert not land(START.copy(), ladders[0], 5, workspace()[0], 1.0 / 3.0)
