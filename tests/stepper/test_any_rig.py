"""Rigs of all kinds against the stored independent solutions."""

import numpy as np
import pytest

from benchmarks.any_rig import DURATION, LIMIT, SAMPLE, error_of, reference, speed_scale
from drillrig_env import Friction, simulate
from tests.reference.any_rig import RIGS, stored
from tests.stepper.test_units import slower, stronger

REFERENCE = stored()


@pytest.mark.parametrize("period", [0.1, 0.02])
def test_no_rig_is_off_by_more_than_a_millionth_of_its_speed_scale(period):
    errors = [error_of(case, speeds, period) for case, speeds in REFERENCE]
    assert len(errors) == RIGS
    assert max(errors) <= LIMIT
    assert np.median(errors) < 1e-9


def test_rigs_are_of_all_kinds():
    rigs = [case.rig for case, _ in REFERENCE]
    for name in ("J_2", "d_1", "L", "k_i", "omega_s"):
        values = [getattr(rig, name) for rig in rigs]
        assert max(values) > 50.0 * min(values)
    assert max(np.abs(speeds).max() for _, speeds in REFERENCE) > 200.0
    assert sum(np.abs(speeds[4:, 0]).min() < case.rig.omega_s for case, speeds in REFERENCE) > RIGS // 3


def scaled_speeds(case, s, tau):
    """Speeds every SAMPLE s of a case whose torques are `s` times as large and whose time runs `tau` times slower."""
    normal_force, mu_s, mu_k, v_b = case.friction.as_array()[0]
    run = simulate(
        slower(stronger(case.rig, s), tau),
        Friction(normal_force, mu_s, mu_k, v_b * tau),
        np.array(case.state) / [1.0, 1.0, tau, tau, tau, 1.0, 1.0],
        case.speed_reference / tau,
        DURATION * tau,
        SAMPLE * tau,
    )
    return run.state[:, 2:5] * tau


@pytest.mark.parametrize(("torque", "time"), [(-40, 0), (0, 20), (39, -20), (7, -3)])
def test_other_powers_of_two_change_no_bit_of_any_rig(torque, time):
    for case, _ in REFERENCE[3::8]:
        found = scaled_speeds(case, 2.0**torque, 2.0**time)
        np.testing.assert_array_equal(found, scaled_speeds(case, 1.0, 1.0))


@pytest.mark.parametrize(("s", "tau"), [(1e-12, 1.0), (1e12, 3.0), (1.0, 1e-6), (0.3, 1e6)])
def test_other_scales_change_no_rig_by_more_than_its_tolerance(s, tau):
    for case, speeds in REFERENCE[::8]:
        assert np.abs(scaled_speeds(case, s, tau) - speeds).max() <= LIMIT * speed_scale(case, speeds)


@pytest.mark.slow
def test_stored_solutions_come_out_again():
    for case, speeds in REFERENCE[::10]:
        found = reference(case)
        assert found is not None
        np.testing.assert_allclose(found, speeds, atol=1e-9 * speed_scale(case, speeds))
