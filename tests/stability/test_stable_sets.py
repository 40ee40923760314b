"""Stable slopes and speeds against the eigenvalues of the Jacobian, of rigs of every kind and size."""

from dataclasses import fields, replace
from fractions import Fraction

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.model import jacobian
from drillrig_env.stability import (
    critical_slope,
    critical_speed,
    eigenvalues,
    equilibria,
    hopf_points,
    hurwitz_minors,
    is_stable,
    stable_slopes,
    stable_speeds,
)

SHAKY = Rig(L=0.995, k_p=0.0087, k_i=2.0, K_E=0.0624, d_2=0.0876, d_1=0.008, J_3=0.0291, J_1=0.0607, J_2=0.0037)
"""Its stable slopes end: what friction holds the bit too fast leaves the drive to shake by itself."""

NEVER = Rig(L=0.26, k_p=0.0, k_i=3.5, K_E=0.0, d_2=0.0013, d_1=0.0076)
WINDOW = Rig(L=0.07, k_p=0.08, k_i=7.4, K_E=0.0835, d_2=0.0036, d_1=0.95, J_3=2.7, J_1=0.147, J_2=0.0077, k_1=0.0106,
             k_2=18.0)  # fmt: skip
TWO = Rig(L=0.265, k_p=0.0, k_i=0.524, K_E=0.0, d_2=0.0044, d_1=0.0922, J_3=0.00172, J_1=0.0518, J_2=0.00207,
          k_1=0.0679, k_2=10.4)  # fmt: skip
FIELD = Rig(J_1=182.6, J_2=107.2, J_3=2954.0, k_1=819.0, k_2=819.0, d_1=20.0, d_2=20.0, eta=1.0, r_1=1.0, L=0.01, R=1.0,
            K_T=1.0, K_E=0.0, C_m=0.0, T_f=0.0, k_p=38e3, k_i=100e3)  # fmt: skip
NUMBERS = [item.name for item in fields(Rig) if item.name not in ("omega_s", "T_r2", "T_f", "r_1")]


def inside(intervals, values):
    low, high = intervals[:, :1], intervals[:, 1:]
    return ((low < values) & (values < high)).any(axis=0)


def random_rig(rng, spread):
    """The chapter's rig with every parameter times 1 / spread to spread, some of what damps the drive left out."""
    changes = {name: getattr(Rig(), name) * spread ** rng.uniform(-1.0, 1.0) for name in NUMBERS}
    if rng.random() < 0.5:
        changes |= {name: 0.0 for name in ("k_p", "K_E", "C_m", "d_1", "d_2") if rng.random() < 0.4}
    return Rig(**changes)


def agrees_with_eigenvalues(rig, rng, count=50):
    """At random slopes, half of them near the borders, and none within 1e-6 of one."""
    intervals = stable_slopes(rig)
    slopes = rig.impedance * rng.choice([-1.0, 1.0], count) * 10.0 ** rng.uniform(-4.0, 1.5, count)
    borders = intervals[np.isfinite(intervals)]
    if len(borders):
        near = rng.choice(borders, count // 2)
        slopes[: count // 2] = near * (
            1.0 + rng.choice([-1.0, 1.0], count // 2) * 10.0 ** rng.uniform(-5, -0.5, count // 2)
        )
        slopes = slopes[(np.abs(slopes[:, None] - borders) > 1e-6 * np.abs(borders)).all(axis=1)]
    values = np.linalg.eigvals(np.array([jacobian(rig, slope) for slope in slopes]))
    largest = values.real.max(axis=1)
    decided = np.abs(largest) > 1e-12 * np.abs(values).max(axis=1)  # beyond the rounding of eigenvalues
    return bool((inside(intervals, slopes) == (largest < 0.0))[decided].all())


@pytest.mark.parametrize(("count", "spread"), [(100, 10.0), (50, 300.0)])
def test_stable_slopes_agree_with_the_eigenvalues_of_random_rigs(count, spread):
    rng = np.random.default_rng(17)
    assert all(agrees_with_eigenvalues(random_rig(rng, spread), rng) for _ in range(count))


@pytest.mark.slow
def test_stable_slopes_agree_with_the_eigenvalues_of_ten_thousand_random_rigs():
    rng = np.random.default_rng(18)
    assert all(agrees_with_eigenvalues(random_rig(rng, 10.0 if i % 2 else 100.0), rng) for i in range(10_000))


@pytest.mark.parametrize(
    ("rig", "ends"),
    [
        (Rig(), [np.inf]),
        (SHAKY, [0.4225]),
        (NEVER, []),
        (WINDOW, [-0.9467]),
        (TWO, [-0.0798, np.inf]),
        (FIELD, [np.inf]),
    ],
)
def test_sets_of_every_kind(rig, ends):
    intervals = stable_slopes(rig)
    assert intervals[:, 1].tolist() == pytest.approx(ends, rel=5e-3)
    assert np.all(np.diff(intervals.ravel()) > 0.0)
    assert agrees_with_eigenvalues(rig, np.random.default_rng(3), 400)


def test_the_chapters_minors_agree():
    for slope in np.linspace(-0.05, 0.3, 41).tolist():
        assert bool((hurwitz_minors(Rig(), slope) > 0.0).all()) == bool(inside(stable_slopes(Rig()), slope)[()])


def test_field_rig_has_the_slope_and_speeds_of_an_independent_computation():
    assert critical_slope(FIELD) == pytest.approx(-10.820638, abs=1e-6)
    for v_b, speed in ((0.2, 20.98898), (0.1, 35.0465), (0.5, 10.22817), (1.0, 5.80723)):
        friction = Friction(3600.0 / 0.4, 1.0, 0.6, v_b)
        assert critical_speed(FIELD, friction) == pytest.approx(speed, abs=2e-5)


@pytest.mark.parametrize("rig", [Rig(), SHAKY, WINDOW, TWO])
def test_torques_and_time_of_another_size_change_nothing_else(rig):
    torque, time = 2.0**-27, 2.0**6
    dimensions = dict.fromkeys(("J_1", "J_2", "J_3"), torque * time**2)
    dimensions |= dict.fromkeys(("d_1", "d_2", "C_m"), torque * time)
    dimensions |= dict.fromkeys(("k_1", "k_2", "K_T", "r_1"), torque) | dict.fromkeys(("L", "K_E", "k_p"), time)
    scaled = replace(rig, **{name: getattr(rig, name) * factor for name, factor in dimensions.items()})
    np.testing.assert_array_equal(stable_slopes(scaled), stable_slopes(rig) * torque * time)
    slow = replace(scaled, omega_s=rig.omega_s / time)
    speeds = stable_speeds(slow, Friction(700.0, v_b=0.8 * time))
    np.testing.assert_allclose(speeds, stable_speeds(rig, Friction(700.0, v_b=0.8)) / time, rtol=1e-14)


@pytest.mark.parametrize(
    ("rig", "friction", "count"),
    [
        (Rig(), Friction(14.0), 2),
        (Rig(), Friction(0.7), 1),
        (Rig(), Friction(0.0), 1),
        (SHAKY, Friction(14.0), 1),
        (NEVER, Friction(14.0), 0),
        (NEVER, Friction(0.0), 0),
        (NEVER, Friction(14.0, 0.3, 0.3), 0),
        (WINDOW, Friction(150.0, v_b=1.3), 1),
        (WINDOW, Friction(1.0), 0),
        (TWO, Friction(30.0, v_b=1.3), 2),
        (TWO, Friction(3e-5), 0),
    ],
)
def test_stable_speeds_are_those_at_which_every_eigenvalue_decays(rig, friction, count):
    intervals = stable_speeds(rig, friction)
    assert len(intervals) == count
    speeds = np.concatenate([np.linspace(1e-4, 9e-4, 5), np.geomspace(1.1e-3, 12.0, 300)])
    borders = intervals.ravel()
    speeds = speeds[(np.abs(speeds[:, None] - borders) > 1e-4).all(axis=1)] if count else speeds
    expected = [eigenvalues(rig, friction, speed).real.max() < 0.0 for speed in speeds.tolist()]
    assert inside(intervals, speeds).tolist() == expected
    assert [is_stable(rig, friction, speed) for speed in speeds.tolist()] == expected
    points = equilibria(rig, friction, speeds)
    assert (points["branch"] == "e2").tolist() == expected


def test_a_batch_has_the_intervals_of_its_frictions_one_at_a_time():
    forces = [0.0, 0.7, 14.0]
    batch = stable_speeds(Rig(), Friction(np.array(forces)))
    assert batch.shape == (3, 2, 2)
    for intervals, force in zip(batch, forces, strict=True):
        alone = stable_speeds(Rig(), Friction(force))
        np.testing.assert_array_equal(intervals[: len(alone)], alone)
        assert np.isnan(intervals[len(alone) :]).all()
    assert stable_speeds(NEVER, Friction(np.array([3.0, 9.0]))).shape == (2, 0, 2)


def test_critical_slope_and_speed_where_the_set_is_not_above_one_number():
    assert critical_slope(SHAKY) == stable_slopes(SHAKY)[0, 0] < 0.0  # stable up to a slope that rises
    assert critical_slope(NEVER) == np.inf
    for rig in (WINDOW, TWO):
        with pytest.raises(
            ValueError, match=r"critical_slope: .* slopes from -.*not above one number; see stable_slopes"
        ):
            critical_slope(rig)
    low, high = stable_slopes(WINDOW)[0]
    touching, reaching = Friction(1.0), Friction(150.0, v_b=1.3)
    assert critical_speed(WINDOW, touching) == np.inf
    with pytest.raises(
        ValueError, match=r"critical_speed: with N_1 = 150 N this rig is stable at speeds from 0\.5.* to"
    ):
        critical_speed(WINDOW, Friction(np.array([1.0, 150.0]), v_b=1.3))
    at_rest = 150.0 * WINDOW.r_1 * 0.194 * 1.3
    assert stable_speeds(WINDOW, reaching)[0] == pytest.approx(np.log(at_rest / -np.array([low, high])) / 1.3)


def test_every_border_is_a_hopf_point_with_its_direction():
    """Eigenvalues on either side show the direction, the speed of the crossing, and the frequency."""
    for rig, friction, labels in (
        (Rig(), Friction(14.0), ["H1", "H2"]),
        (SHAKY, Friction(14.0), ["H2"]),
        (WINDOW, Friction(150.0, v_b=1.3), ["H2", "H3"]),
        (TWO, Friction(30.0, v_b=1.3), ["H1", "H2", "H3"]),
    ):
        points = hopf_points(rig, friction)
        assert [point.label for point in points] == labels
        ends = stable_speeds(rig, friction).ravel()
        assert [point.speed_reference for point in points] == ends[(ends > 0.0) & (ends < np.inf)].tolist()
        for point in points:
            step = 1e-6
            below, above = (eigenvalues(rig, friction, point.speed_reference + s)[0] for s in (-step, step))
            assert (below.real < 0.0) == (point.direction == "unstable") == (above.real > 0.0)
            if point.criticality != "kink":
                assert (above.real - below.real) / (2 * step) == pytest.approx(point.crossing_speed, rel=1e-3)
                assert abs(above.imag) == pytest.approx(point.frequency, rel=1e-4)


@pytest.mark.parametrize("slope", [Fraction(10) ** 400, Fraction(1, 10**400)])
def test_a_border_that_no_double_can_hold_is_refused(slope, monkeypatch):
    monkeypatch.setattr("drillrig_env.stability.stable_sets._borders", lambda rig: [(slope, 1.0)])
    with pytest.raises(FloatingPointError, match="stable_slopes: a border of stability that no double can hold"):
        stable_slopes(Rig(J_1=0.0289))
