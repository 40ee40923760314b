"""Units of a rig's own, and the invariance that comes from them."""

from dataclasses import replace

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.stepper.units import units_of

TORQUES = ["J_1", "J_2", "J_3", "k_1", "k_2", "d_1", "d_2", "C_m", "T_f", "K_T", "r_1"]
START = np.array([-0.1, -0.4, 2.5, 2.0, 2.1, 0.9, 0.6])
OTHER = Rig(J_1=0.05, k_2=0.4, L=2e-3, T_r2=0.02, k_p=1.1)


def stronger(rig, s):
    return replace(rig, **{name: getattr(rig, name) * s for name in [*TORQUES, "T_r2"]})


def slower(rig, tau):
    """The rig whose time runs `tau` times slower."""
    squared = {name: getattr(rig, name) * tau**2 for name in ("J_1", "J_2", "J_3")}
    once = {name: getattr(rig, name) * tau for name in ("d_1", "d_2", "C_m", "L", "K_E", "k_p")}
    return replace(rig, **squared, **once, omega_s=rig.omega_s / tau)


def run(rig, tau=1.0):
    start = START * np.array([1.0, 1.0, 1.0 / tau, 1.0 / tau, 1.0 / tau, 1.0, 1.0])
    friction = Friction(22.0, 0.5, 0.3, 1.3 * tau)
    states = simulate(rig, friction, start, 2.3 / tau, duration=8.0 * tau, sample_period=0.05 * tau).state.copy()
    states[:, 2:5] *= tau
    return states


def test_the_chapters_rig_is_the_unit():
    units = units_of(Rig())
    assert (units.time, units.torque, units.current) == (1.0, 1.0, 1.0)
    np.testing.assert_array_equal(units_of(slower(Rig(), 8.0)).states, [1, 1, 0.125, 0.125, 0.125, 1, 1])
    assert units_of(stronger(Rig(), 0.25)).torque == 0.25


@pytest.mark.parametrize("rig", [Rig(), OTHER], ids=["chapter", "other"])
@pytest.mark.parametrize("exponent", [-40, -3, 1, 27])
def test_torques_of_another_power_of_two_change_no_bit(rig, exponent):
    np.testing.assert_array_equal(run(stronger(rig, 2.0**exponent)), run(rig))


@pytest.mark.parametrize("rig", [Rig(), OTHER], ids=["chapter", "other"])
@pytest.mark.parametrize("exponent", [-20, -1, 3, 20])
def test_time_of_another_power_of_two_changes_no_bit(rig, exponent):
    np.testing.assert_array_equal(run(slower(rig, 2.0**exponent), 2.0**exponent), run(rig))


@pytest.mark.parametrize("s", [1e-12, 3e-5, 0.7, 1e12])
def test_torques_of_any_other_scale_change_nothing_but_rounding(s):
    np.testing.assert_allclose(run(stronger(OTHER, s))[:, 2:5], run(OTHER)[:, 2:5], atol=1e-6)


@pytest.mark.parametrize("tau", [1e-6, 1 / 6.5, 1.3, 1e6])
def test_time_of_any_other_scale_changes_nothing_but_rounding(tau):
    np.testing.assert_allclose(run(slower(OTHER, tau), tau)[:, 2:5], run(OTHER)[:, 2:5], atol=1e-6)
