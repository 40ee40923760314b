"""The fold against an independent value, against creeping sweeps, and against what rigs do on either side of it."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.model import steady_state, wound_up
from drillrig_env.stability import (
    NoOrbitError,
    basin_depth,
    critical_slope,
    critical_speed,
    fold_speed,
    slipping_orbit,
    stick_slip_orbit,
)
from drillrig_env.stability.slipping_orbits import slipping_orbits
from drillrig_env.stepper.batch import advance_batch

RIG = Rig()


def random_frictions(count, seed=1):
    rng = np.random.default_rng(seed)
    return Friction(
        rng.uniform(2.0, 40.0, count),
        rng.uniform(0.42, 0.6, count),
        rng.uniform(0.24, 0.36, count),
        rng.uniform(0.7, 1.3, count),
    )


def one(friction, rig):
    return Friction(*friction.as_array()[rig].tolist())


def test_value_at_10_n_of_an_independent_computation():
    assert fold_speed(RIG, Friction(10.0)) == pytest.approx(2.900973, abs=1e-5)
    assert fold_speed(RIG, Friction(10.0)) == pytest.approx(2.9, abs=0.002)  # the chapter's figure 4.12


def test_batch_is_its_frictions_one_at_a_time():
    friction = random_frictions(20)
    np.testing.assert_allclose(
        fold_speed(RIG, friction), [fold_speed(RIG, one(friction, i)) for i in range(20)], rtol=1e-12
    )


def test_weak_friction_has_no_bistable_region():
    weak = Friction(np.array([0.0, 0.5, 1.0, 10.0]))
    assert np.isnan(fold_speed(RIG, weak)).tolist() == [True, True, True, False]


@pytest.mark.parametrize(("speed", "exists"), [(0.0, False), (9e-4, False), (1.1e-3, True), (0.05, True), (0.9, True)])
def test_fold_exists_from_where_the_critical_speed_leaves_the_stick_zone(speed, exists):
    force = -critical_slope(RIG) * np.exp(speed) / (RIG.r_1 * 0.194)
    fold = fold_speed(RIG, Friction(force))
    assert np.isfinite(fold) == exists
    assert not exists or fold > speed


def test_fold_parts_orbits_that_stick_from_none():
    fold = fold_speed(RIG, Friction(2.0))
    assert stick_slip_orbit(RIG, Friction(2.0), 0.98 * fold).stuck > 0.0
    with pytest.raises(NoOrbitError):
        stick_slip_orbit(RIG, Friction(2.0), 1.02 * fold)


def test_basin_is_as_deep_as_the_unstable_orbit_swings():
    friction = Friction(20.0, v_b=1.2)
    border, fold = critical_speed(RIG, friction), fold_speed(RIG, friction)
    for share in (0.1, 0.5, 0.9):
        speed = border + share * (fold - border)
        orbit = slipping_orbit(RIG, friction, speed)
        assert basin_depth(RIG, friction, speed) == pytest.approx(speed - orbit.lowest[0], abs=1e-5)
    assert basin_depth(RIG, friction, border) == pytest.approx(0.0, abs=1e-6)
    assert basin_depth(RIG, friction, 0.5 * border) == 0.0
    assert basin_depth(RIG, Friction(np.array([10.0, 20.0])), np.array([2.5, 3.5])).shape == (2,)


def test_bistable_range_is_wider_at_20_n_than_at_10_n():
    width = fold_speed(RIG, Friction(np.array([10.0, 20.0]))) - critical_speed(RIG, Friction(np.array([10.0, 20.0])))
    assert width[1] > width[0] > 0.5


def test_too_heavy_a_load_is_refused_before_its_orbits_are_looked_for(monkeypatch):
    asked = []

    def noted(rig, reach, samples):
        asked.append((reach, samples))
        return slipping_orbits(rig, reach, samples)

    monkeypatch.setattr("drillrig_env.stability.fold.slipping_orbits", noted)
    for rig, force in ((RIG, 1e6), (Rig(r_1=300.0), 20.0)):
        with pytest.raises(
            ValueError, match=r"N_1 r_1 \(mu_s - mu_k\) v_b = .* N m s/rad is not allowed; allowed: < 1"
        ):
            fold_speed(rig, Friction(force))
    assert asked == [(12.0, 256)] * 2


def test_the_fold_of_a_deep_orbit_grows_as_the_load_does():
    """Under heavy loads friction has long fallen where the bit is fast: all speeds go by what it falls."""
    folds = fold_speed(RIG, Friction(np.array([150.0, 300.0, 450.0])))
    assert np.diff(folds)[1] == pytest.approx(np.diff(folds)[0], rel=0.05)


def still_sticks(friction, speed, states, seconds=150.0):
    ends = advance_batch(RIG, friction, states, speed, periods=round(seconds / 0.1), threads=2)
    return ends[:, -100:, 2].min(axis=1) < 0.1


def test_both_starts_stay_between_critical_speed_and_fold_and_only_one_outside():
    friction = random_frictions(40)
    fold, border = fold_speed(RIG, friction), critical_speed(RIG, friction)
    bistable = border > 0.3
    for speed, from_stick, from_calm in (
        (0.995 * fold, True, False),
        (1.005 * fold, False, False),
        (0.9 * border + 0.1 * fold, True, False),
        (0.9 * border, True, True),
    ):
        wound = wound_up(RIG, friction, speed)
        nudged = steady_state(RIG, friction, speed) + 0.002 * np.eye(7)[2]
        assert (still_sticks(friction, speed, wound, 400.0)[bistable] == from_stick).all()
        assert (still_sticks(friction, speed, nudged, 400.0)[bistable] == from_calm).all()


def test_creeping_sweeps_leave_stick_slip_at_the_fold_for_thirty_frictions():
    """Brute force: the reference creeps up at 1e-4 rad/s^2 until the bit has all but stopped for the last time."""
    friction = random_frictions(30, seed=5)
    fold = fold_speed(RIG, friction)
    speed = fold - 0.015
    states = wound_up(RIG, friction, speed)
    states = advance_batch(RIG, friction, states, speed, periods=300)[:, -1]
    last = np.full(30, np.nan)
    for _ in range(3000):
        samples = advance_batch(RIG, friction, states, speed, period=0.02, periods=5)
        states = samples[:, -1]
        last = np.where(samples[:, :, 2].min(axis=1) < 0.005, speed, last)
        speed = speed + 1e-5
    np.testing.assert_allclose(last, fold, atol=5e-3)
