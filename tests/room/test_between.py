"""What is drawn between control steps, against the stepper with steps a sixteenth as long."""

import numpy as np
import pytest

from drillrig_env.drive import Drive
from drillrig_env.env.task import Task
from drillrig_env.model import wound_up
from drillrig_env.rig import Rig
from drillrig_env.room.between import Between
from drillrig_env.stepper.batch import advance_batch
from drillrig_env.stepper.ladder import SAMPLES


@pytest.mark.parametrize(
    ("rig", "drive", "tolerance"),
    [
        (Rig(), None, 1e-4),
        (Rig(C_1=0.02, C_2=0.01), None, 1e-4),
        (Rig(T_r2=0.05), None, 1e-2),  # whose disc 2 sticks now and then, which no linear part tells
        (Rig(), Drive(1.2, 0.6, back_emf_share=0.5, voltage_offset=0.2), 1e-4),
        (Rig.preset("field_2500m"), None, 1e-4),
    ],
)
def test_states_between_are_those_of_shorter_steps(rig, drive, tolerance):
    task = Task(rig=rig, drive=drive)
    friction, reference = task.scales.friction, 2.0 * task.scales.speed
    between, state = Between(task), wound_up(rig, friction, reference)
    short = {"period": task.control_period / SAMPLES, "periods": SAMPLES, "drive": drive}
    largest, worst = np.zeros(7), np.zeros(7)
    for _ in range(40):
        fine = advance_batch(rig, friction, state[None], reference, **short)[0]
        found = between.states(state, fine[-1], fine[:, 2], reference)
        np.testing.assert_allclose(found[:, -1], fine[-1], rtol=1e-12, atol=1e-12)
        largest = np.maximum(largest, np.abs(fine).max(axis=0))
        worst = np.maximum(worst, np.abs(found - fine.T).max(axis=1))
        state = fine[-1]
    assert np.all(worst <= tolerance * largest)


def test_an_end_that_is_not_the_linear_one_is_met():
    end = np.arange(7.0)
    found = Between(Task()).states(np.zeros(7), end, np.full(SAMPLES, 2.0), 0.0)
    np.testing.assert_allclose(found[:, -1], end, atol=1e-12)
