"""The drive's record: what stands for one, what it means in the model, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from drillrig_env import Drive, Rig
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.model import frictionless_state, jacobian, state_equations

SOFT = Drive(0.04, 0.06, 1.0)


@pytest.mark.parametrize(
    "given",
    [
        SOFT,
        (0.04, 0.06, 1.0),
        [0.04, 0.06, 1],
        np.array([0.04, 0.06, 1.0]),
        {"k_p": 0.04, "k_i": 0.06, "back_emf_share": 1.0},
        SOFT.as_dict(),
    ],
)
def test_stands_for_the_same_drive(given):
    assert Drive.of(given) == SOFT


def test_none_is_the_rigs_own_and_two_gains_make_up_for_nothing():
    assert Drive.of(None) is None
    assert Drive.of((3.0, 1.0)) == Drive.of_rig(Rig()) == Drive.of({"k_p": 3.0, "k_i": 1.0})


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("12", "drive = '12' is not allowed"),
        (3.0, "drive = 3.0 is not allowed"),
        ((1.0,), "with or without the share"),
        ((1.0, 1.0, 0.0, 0.0), "with or without the share"),
        ((1.0, 0.0), "k_i = 0.0 V/rad"),
        ((-1.0, 1.0), "k_p = -1.0 V s/rad"),
        ((1.0, 1.0, 1.5), "back_emf_share = 1.5"),
        ((True, 1.0), "k_p = True is not a number"),
        (("1", "2"), "k_p = '1' is text; write 1"),
        ((float("nan"), 1.0), "k_p = nan"),
        ({"k_p": 1.0}, "the field k_i is missing"),
        ({"k_p": 1.0, "k_j": 1.0}, "unknown field 'k_j'; did you mean k_"),
    ],
)
def test_what_is_no_drive_is_refused(given, words):
    with pytest.raises(ValueError, match=words):
        Drive.of(given)
    with pytest.raises(ValueError, match=words):
        EpisodeBatch(1, drive=given)


def test_the_rigs_own_drive_changes_no_bit():
    rig, own = Rig(), Drive.of_rig(Rig())
    np.testing.assert_array_equal(jacobian(rig, 0.01, own), jacobian(rig, 0.01))
    np.testing.assert_array_equal(frictionless_state(rig, 2.0, own), frictionless_state(rig, 2.0))
    assert own.compensation(rig) == 0.0


def test_what_holds_still_on_a_drive_is_at_rest_under_its_voltage():
    """The state equations with the drive's voltage written out: u = k_p (omega_ref - x_5) + k_i x_7 + s eta K_E x_5."""
    rig, drive, speed = Rig(), Drive(0.3, 0.2, 0.7), 2.5
    x = frictionless_state(rig, speed, drive)
    written_out = replace(rig, k_p=drive.k_p, k_i=drive.k_i)
    rates = np.array(state_equations(x, speed, 0.0, written_out))
    rates[5] += drive.back_emf_share * rig.eta * rig.K_E * x[4] / rig.L
    np.testing.assert_allclose(rates, 0.0, atol=1e-9)


def test_making_up_for_the_back_emf_is_a_lower_proportional_gain_where_the_reference_is_constant():
    """eta K_E x_5 more voltage is eta K_E less of k_p, but for what k_p makes of the reference."""
    rig = Rig()
    lower = replace(rig, k_p=0.6 - 0.5 * rig.eta * rig.K_E, k_i=0.06, K_E=0.5 * rig.K_E)
    np.testing.assert_allclose(jacobian(rig, drive=Drive(0.6, 0.06, 1.0)), jacobian(lower), atol=1e-9)
