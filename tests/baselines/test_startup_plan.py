"""Pieces of a planned start, each against what it is planned to be."""

import numpy as np
import pytest

from baselines.startup_plan import Haste, _acceleration, _rate_of_lag, _speed_reference, _wind_up, startup_plan
from drillrig_env import Rig

_STEP = 0.1 / 50  # fine samples of a plan, s
HASTE = Haste(acceleration=1.4, build_up=1.0)
CONTACT = (15.0, 0.5, 0.306, 1.0)
STATIC = 15.0 * 0.0485 * 0.5


@pytest.mark.parametrize(("begin", "end", "first", "last"), [(0.1, 0.4, 0.05, 0.3), (0.0, 0.36, 0.0, 0.063)])
def test_wind_up_begins_and_ends_at_its_torques_with_its_rates(begin, end, first, last):
    torque = _wind_up(begin, end, first, last, _STEP)
    assert torque[0] == pytest.approx(begin)
    assert torque[-1] == pytest.approx(end, abs=2 * last * _STEP + 1e-4)
    rates = np.diff(torque) / _STEP
    assert rates[0] == pytest.approx(first, abs=0.01)
    assert rates[-1] == pytest.approx(last, abs=0.01)
    assert len(torque) * _STEP == pytest.approx(2.0 * (end - begin) / (first + last), abs=0.01)


def test_a_string_that_is_nearly_wound_up_still_takes_half_a_second():
    assert len(_wind_up(0.36, 0.3601, 0.3, 0.3, _STEP)) * _STEP == pytest.approx(0.5, abs=2 * _STEP)


@pytest.mark.parametrize(("speed", "peak"), [(4.0, 1.4), (0.5, 0.5 / (2.0 / np.pi + 0.5))])
def test_acceleration_brings_the_bit_to_its_speed_within_its_limit(speed, peak):
    """From nothing and back to nothing; a slow goal is reached with less than is allowed."""
    found = _acceleration(speed, HASTE, _STEP)
    assert found.sum() * _STEP == pytest.approx(speed, rel=1e-4)
    assert found.max() == pytest.approx(peak, rel=1e-4)
    assert found.min() >= 0.0
    assert found[0] < 0.01 * peak
    assert np.all(found[-round(2.9 / _STEP) :] == 0.0)
    rising = found[: round(1.0 / _STEP)]
    np.testing.assert_allclose(rising, peak * np.sin(0.5 * np.pi * (np.arange(len(rising)) + 0.5) * _STEP), atol=1e-3)


@pytest.mark.parametrize(("time_constant", "accuracy"), [(0.02, 2e-3), (3.0, 1e-6)])
def test_rate_of_a_lag_on_a_ramp_is_the_closed_form(time_constant, accuracy):
    """x' of tau x' + x = s t from x'(0) = f: s + (f - s) exp(-t / tau)."""
    t = _STEP * np.arange(2000)
    found = _rate_of_lag(0.7 + 0.3 * t, time_constant, first=-0.1, step=_STEP)
    np.testing.assert_allclose(found, 0.3 - 0.4 * np.exp(-t / time_constant), atol=accuracy)


def test_rate_of_a_lag_too_short_to_be_seen_is_that_of_its_aim():
    t = _STEP * np.arange(200)
    np.testing.assert_allclose(_rate_of_lag(np.sin(t), 1e-4, 5.0, _STEP), np.cos(t), atol=0.01)


def test_plan_has_an_entry_a_control_step_and_sticks_until_it_is_wound_up():
    plan = startup_plan(Rig(), CONTACT, 0.2, 0.0, 3.0, HASTE)
    assert len(plan.time) == len(plan.bit_speed) == 50 * len(plan.references)
    assert plan.time[1] == pytest.approx(0.1 / 50)
    stuck = plan.bit_speed < Rig().omega_s
    assert plan.bit_speed[0] == pytest.approx(1e-3 * 0.2 / STATIC)
    rate = 0.0288 * 1.4 * np.pi / 2.0
    stiffness_rate = 1.1175 * 0.3659 / (1.1175 + 0.3659) * (0.0 - 1e-3 * 0.2 / STATIC)
    assert stuck.sum() * _STEP == pytest.approx(2.0 * (STATIC - 0.2) / (rate + stiffness_rate), rel=0.01)
    assert plan.bit_speed[-1] == pytest.approx(3.0, abs=2e-3)


def test_more_than_break_loose_counts_as_break_loose_and_no_load_needs_no_winding():
    over, at = (startup_plan(Rig(), CONTACT, torque, 0.0, 3.0, HASTE) for torque in (0.9, STATIC))
    np.testing.assert_array_equal(over.references, at.references)
    free = startup_plan(Rig(), (0.0, 0.5, 0.306, 1.0), 0.0, 0.0, 3.0, HASTE)
    assert np.isfinite(free.references).all()
    assert free.bit_speed[-1] == pytest.approx(3.0, abs=2e-3)


def test_collars_under_a_torque_take_more_voltage_and_end_at_the_same_speed():
    plain, loaded = (startup_plan(rig, CONTACT, 0.2, 0.0, 3.0, HASTE) for rig in (Rig(), Rig(T_r2=0.1)))
    np.testing.assert_array_equal(plain.bit_speed, loaded.bit_speed)
    assert loaded.references[-1] == pytest.approx(plain.references[-1], abs=0.02)


def test_a_winding_string_is_taken_over_as_it_moves():
    """The wind-up begins with the rate at which the drive goes on winding."""
    still, winding = (startup_plan(Rig(), CONTACT, 0.2, w, 3.0, HASTE) for w in (0.0, 0.2))
    creep = [np.diff(plan.bit_speed[:3])[0] * STATIC / 1e-3 / _STEP for plan in (still, winding)]
    assert creep[1] - creep[0] == pytest.approx(0.2 * 1.1175 * 0.3659 / (1.1175 + 0.3659), rel=0.02)


@pytest.mark.parametrize("rise", [0.3, 0.03, -0.2])
@pytest.mark.parametrize("rig", [Rig(), Rig(T_r2=0.1, k_p=2.0)])
def test_a_string_that_is_wound_up_evenly_takes_the_reference_of_the_closed_form(rig, rise):
    """The top turns ahead of the bit by the rates of both twists; the lag of the speed loop begins at omega_ref = 0."""
    t = _STEP * np.arange(1500)
    found = _speed_reference(rig, np.full(len(t), 0.5), 0.1 + rise * t, _STEP)
    top_speed = 0.5 + rise / rig.k_1 + rise / rig.k_2
    integrator_rate = rig.R / (rig.eta * rig.K_T) * rise / rig.k_i
    expected = (top_speed + integrator_rate) * (1.0 - np.exp(-t * rig.k_i / rig.k_p))
    np.testing.assert_allclose(found, expected, atol=0.05 * abs(rise))


def test_a_start_from_omega_ref_0_begins_with_what_the_inertia_of_the_drive_takes():
    """A stiff string turns the drive as the bit is turned; its acceleration takes a voltage that only k_p can give."""
    rig = Rig(k_1=1e6, k_2=1e6, k_p=2.0)
    t = _STEP * np.arange(500)
    first = _speed_reference(rig, 0.5 + 0.8 * t, np.full(len(t), 0.2), _STEP)[0]
    assert first == pytest.approx(rig.R / (rig.eta * rig.K_T) * rig.J_3 * 0.8 / rig.k_p, rel=1e-6)
