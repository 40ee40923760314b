"""What an orbit tells of itself."""

from dataclasses import replace

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.model import steady_state
from drillrig_env.stability import critical_speed, end_of_stick_slip, fold_speed, slipping_orbit, stick_slip_orbit
from drillrig_env.stability.limit_cycle import NoOrbitError
from drillrig_env.stability.return_map import ReturnMap
from drillrig_env.stepper.batch import advance_batch

RIG = Rig()
STICKING = stick_slip_orbit(RIG, Friction(20.0), 2.0)


@pytest.mark.parametrize(
    ("multipliers", "stable"),
    [
        ([1.0, 0.9, -0.5], True),
        ([1.0001, 0.99, 0.1], True),  # the trivial one is 1 but for rounding
        ([1.2, 1.0, 0.1], False),
        ([1.0, -1.01, 0.1], False),
        ([1.0, 0.8 + 0.7j, 0.8 - 0.7j], False),
    ],
)
def test_stable_is_every_multiplier_but_the_trivial_one_inside_the_unit_circle(multipliers, stable):
    assert replace(STICKING, multipliers=np.array(multipliers, dtype=complex)).stable == stable


def test_state_lies_on_the_section_and_the_trajectory_closes():
    assert STICKING.state[2] == pytest.approx(2.0, abs=1e-9)
    time, states = STICKING.trajectory(300)
    assert time.shape == (301,)
    assert states.shape == (301, 7)
    assert time[-1] == pytest.approx(STICKING.period)
    np.testing.assert_allclose(states[-1], states[0], atol=1e-5)
    assert states[1, 2] > states[0, 2]  # the bit speeds up there
    few, _ = STICKING.trajectory(10)  # steps longer than the stepper takes at once
    assert few[-1] == pytest.approx(STICKING.period)


def test_extremes_and_stuck_share_are_those_of_the_trajectory():
    _, states = STICKING.trajectory(4000)
    np.testing.assert_allclose(STICKING.highest, states[:, 2:6].max(axis=0), atol=1e-4)
    np.testing.assert_allclose(STICKING.lowest, states[:, 2:6].min(axis=0), atol=1e-3)
    assert STICKING.stuck == pytest.approx(np.mean(np.abs(states[:-1, 2]) < RIG.omega_s), abs=2e-3)


def test_multipliers_are_of_falling_size_and_multiply_what_the_flow_does_to_a_small_step():
    orbit = slipping_orbit(RIG, Friction(10.0), 2.4)
    sizes = np.abs(orbit.multipliers)
    assert np.all(np.diff(sizes) <= 0)
    step = 1e-5 * np.random.default_rng(0).normal(size=7)
    for _ in range(20):  # a step turns into the direction that grows most
        start = (orbit.state + step)[None]
        moved = advance_batch(
            RIG, Friction(10.0), start, orbit.speed_reference, period=orbit.period / 40, periods=40, every=40
        )[0, 0]
        growth = np.linalg.norm(moved - orbit.state) / np.linalg.norm(step)
        step = (moved - orbit.state) * 1e-5 / np.linalg.norm(moved - orbit.state)
    assert growth == pytest.approx(sizes[0], rel=0.02)


def test_guess_leads_to_the_same_orbit_in_any_state_near_it():
    again = stick_slip_orbit(RIG, Friction(20.0), 2.0, STICKING.state + 1e-3)
    assert again.period == pytest.approx(STICKING.period, abs=1e-6)
    np.testing.assert_allclose(again.state, STICKING.state, atol=1e-5)


@pytest.mark.parametrize("share", [1e-4, 1e-5, 1e-6])
@pytest.mark.parametrize(
    ("rig", "friction"),
    [
        (RIG, Friction(10.0)),
        (RIG, Friction(27.8, mu_s=0.593, mu_k=0.344, v_b=1.08)),
        (Rig(J_1=0.021, J_2=0.0237, k_1=1.51, d_1=0.0276), Friction(27.8, mu_s=0.399, mu_k=0.297, v_b=1.17)),
    ],
)
def test_the_orbit_is_found_and_measured_just_below_the_fold(rig, friction, share):
    speed = fold_speed(rig, friction) * (1.0 - share)
    orbit = stick_slip_orbit(rig, friction, speed)
    assert orbit.lowest[0] < rig.omega_s + 1e-5
    assert 0.0 < orbit.stuck < 0.007
    assert orbit.stable
    assert abs(orbit.multipliers[0] - 1.0) < 1e-4  # the trivial one: no step of the differences left the stick zone
    state, returns = orbit.state, ReturnMap(rig, friction)
    for _ in range(20):
        passage = returns(state, speed)
        state = passage.state
    np.testing.assert_allclose(state, orbit.state, atol=1e-5)
    assert passage.time == pytest.approx(orbit.period, abs=1e-6)


@pytest.mark.parametrize(
    ("rig", "friction", "share"),
    [
        (Rig(d_1=0.0, d_2=0.0), Friction(12.0), 0.1),  # the wound-up rig becomes calm
        (Rig(d_1=0.0, d_2=0.0), Friction(12.0), 1e-3),
        (Rig(omega_s=1e-11), Friction(15.0), 1e-3),
        (Rig(omega_s=1e-8), Friction(30.0), 0.3),
        (Rig(k_p=0.0, K_E=0.002), Friction(12.0), 1e-4),
    ],
)
def test_the_orbit_is_found_up_to_the_end_though_no_wound_up_rig_comes_to_it(rig, friction, share):
    end = end_of_stick_slip(rig, friction)
    orbit = stick_slip_orbit(rig, friction, float(end.speed) * (1.0 - share))
    assert orbit.stable
    assert orbit.stuck > 0.0
    later = advance_batch(
        rig, friction, orbit.state[None], orbit.speed_reference, period=orbit.period / 40, periods=40, every=40
    )[0, 0]
    np.testing.assert_allclose(later, orbit.state, atol=2e-5)


def test_a_stick_zone_too_thin_for_doubles_is_as_good_as_none():
    thin, thinner = (stick_slip_orbit(Rig(omega_s=width), Friction(12.0), 1.5) for width in (1e-5, 1e-13))
    assert thinner.period == pytest.approx(thin.period, abs=5e-5)
    np.testing.assert_allclose(thinner.multipliers, thin.multipliers, atol=5e-5)


def test_above_the_fold_there_is_none():
    fold = fold_speed(RIG, Friction(10.0))
    with pytest.raises(NoOrbitError, match=r"it does up to 2\.90097 rad/s"):
        stick_slip_orbit(RIG, Friction(10.0), fold + 1e-4)


def test_a_guess_that_leads_nowhere_does_no_harm():
    fold = fold_speed(RIG, Friction(10.0))
    orbit = stick_slip_orbit(RIG, Friction(10.0), 0.97 * fold)
    calm = steady_state(RIG, Friction(10.0), 0.97 * fold)
    again = stick_slip_orbit(RIG, Friction(10.0), 0.97 * fold, calm + 1e-4)
    assert again.period == pytest.approx(orbit.period, abs=1e-6)


def test_slipping_orbit_exists_up_to_the_fold_and_not_at_the_critical_speed():
    border, fold = critical_speed(RIG, Friction(20.0)), fold_speed(RIG, Friction(20.0))
    assert slipping_orbit(RIG, Friction(20.0), fold).lowest[0] == pytest.approx(RIG.omega_s, abs=2e-3)
    assert slipping_orbit(RIG, Friction(20.0), border + 1e-4).lowest[0] > border - 0.1
    for speed in (border, fold + 1e-6):
        with pytest.raises(NoOrbitError, match="p2: no orbit at"):
            slipping_orbit(RIG, Friction(20.0), speed)
    with pytest.raises(ValueError, match=r"speed_reference = 0\.0 rad/s"):
        slipping_orbit(RIG, Friction(20.0), 0.0)


def test_collars_under_a_torque_of_their_own_leave_the_orbit_the_same_but_for_twist_and_current():
    """T_r2 is constant and adds to what the lower shaft carries: speeds do not know of it."""
    loaded = slipping_orbit(Rig(T_r2=0.2), Friction(20.0), 3.0)
    plain = slipping_orbit(RIG, Friction(20.0), 3.0)
    assert loaded.period == pytest.approx(plain.period, abs=1e-6)
    np.testing.assert_allclose(loaded.lowest[:3], plain.lowest[:3], atol=1e-4)
    assert loaded.lowest[3] - plain.lowest[3] == pytest.approx(0.2 / (RIG.eta * RIG.K_T), abs=1e-3)
