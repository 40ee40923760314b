import numpy as np
import pytest

from baselines import SoftTorque
from baselines.tune import tuning_suite
from drillrig_env import Rig
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from tests.baselines.episode import BISTABLE, LOAD_STEP, UNSTABLE, play


@pytest.mark.parametrize("options", [BISTABLE, UNSTABLE, LOAD_STEP], ids=["bistable", "unstable", "load step"])
def test_frees_holds_and_keeps_out_with_the_reference_at_the_target(options):
    info, references = play(SoftTorque(), options)
    assert info["is_success"]
    assert np.ptp(references) < 1e-4  # the drive does it


def test_gains_of_the_drive_give_the_wanted_proportional_and_integral_torque():
    rig = Rig()
    drive = SoftTorque(proportional=0.17, integral=0.2).drive
    per_volt = rig.eta * rig.K_T / rig.R
    assert per_volt * drive.k_p + rig.eta**2 * rig.C_m == pytest.approx(0.17)
    assert per_volt * drive.k_i == pytest.approx(0.2)
    assert drive.back_emf_share == 1.0  # or the back-EMF alone would be 1.66 N m s/rad


def test_needs_no_measurement_at_all():
    policy = SoftTorque(("speed_reference", "speed_target"))
    assert play(policy, BISTABLE)[0]["is_success"]


def test_reaches_its_mark_on_random_rigs():
    scores = score(run(SoftTorque(), tuning_suite("default", 200, 590_000_000)))
    assert scores["mitigated"].mean() > 0.95
    assert scores["mitigated"][scores["region"] == "below"].mean() > 0.85


def test_refuses_impossible_gains_and_sensors():
    with pytest.raises(ValueError, match=r"SoftTorque: integral = 0.0 N m/rad is not allowed; allowed: > 0 N m/rad"):
        SoftTorque(integral=0.0)
    with pytest.raises(ValueError, match=r"SoftTorque: proportional = -0.1 N m s/rad is not allowed"):
        SoftTorque(proportional=-0.1)
    with pytest.raises(ValueError, match=r"SoftTorque reads speed_target, which .* state, encoders, surface"):
        SoftTorque(("speed_reference", "top_speed"))
