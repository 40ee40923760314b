"""Stability under other laws of friction than the chapter's: against eigenvalues, and against simulation."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.model import steady_state
from drillrig_env.stability import (
    bifurcation_diagram,
    critical_slope,
    critical_speed,
    eigenvalues,
    end_of_stick_slip,
    fold_speed,
    force_diagram,
    hopf_points,
    is_stable,
    slipping_orbit,
    stable_speeds,
    stick_slip_orbit,
)
from drillrig_env.stability.slope_of_law import speeds_at_slope, third_derivative
from tests.rigs import scaled

RIG = Rig()
LAWS = ("gaussian", "linear")


def growth(friction, speed):
    return eigenvalues(RIG, friction, speed)[0].real


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("force", "v_b"), [(6.0, 1.0), (25.0, 0.4), (60.0, 3.0)])
def test_critical_speed_is_where_the_eigenvalues_say(law, force, v_b):
    friction = Friction(force, v_b=v_b, law=law)
    speed = critical_speed(RIG, friction)
    assert growth(friction, speed * (1 - 1e-6)) > 0.0 > growth(friction, speed * (1 + 1e-6))
    above = speed * np.linspace(1.001, 20.0, 40)
    assert max(growth(friction, one) for one in above) < 0.0


@pytest.mark.parametrize("law", LAWS)
def test_stable_speeds_are_all_of_them(law):
    friction = Friction(9.0, v_b=0.7, law=law)
    intervals = stable_speeds(RIG, friction)
    for speed in np.geomspace(1e-4, 30.0, 300):
        inside = bool(np.any((intervals[:, 0] < speed) & (speed < intervals[:, 1])))
        assert inside == (growth(friction, speed) < 0.0) == is_stable(RIG, friction, speed)


def test_low_speeds_are_stable_under_a_gaussian_fall():
    (low, high), (last, end) = stable_speeds(RIG, Friction(10.0, law="gaussian"))
    assert (low, end) == (0.0, np.inf)
    assert 0.0 < high < last == pytest.approx(critical_speed(RIG, Friction(10.0, law="gaussian")), rel=1e-12)


def test_speeds_of_a_slope_are_those_of_the_closed_form():
    friction, slope = Friction(np.array([8.0, 30.0]), v_b=np.array([0.5, 2.0]), law="gaussian"), critical_slope(RIG)
    found = [speeds_at_slope(RIG, one, slope)[-1] for one in friction.each()]
    np.testing.assert_allclose(critical_speed(RIG, friction), found, rtol=1e-12)


@pytest.mark.parametrize("law", LAWS)
def test_friction_that_never_falls_so_steeply_leaves_every_speed_stable(law):
    weak = Friction(10.0, v_b=0.05, law=law)
    assert critical_speed(RIG, weak) == 0.0
    assert stable_speeds(RIG, weak).tolist() == [[0.0, np.inf]]
    assert hopf_points(RIG, weak) == []
    assert end_of_stick_slip(RIG, weak).kind == "none"
    assert np.isnan(fold_speed(RIG, weak))


def test_hopf_points_of_a_gaussian_fall_cross_as_eigenvalues_do():
    friction = Friction(12.0, v_b=0.8, law="gaussian")
    points = hopf_points(RIG, friction)
    assert [point.direction for point in points] == ["unstable", "stable"]
    for point in points:
        step = 1e-6
        ahead, behind = (growth(friction, point.speed_reference + k * step) for k in (1, -1))
        assert point.crossing_speed == pytest.approx((ahead - behind) / (2 * step), rel=1e-5)


def test_third_derivative_is_the_gaussians():
    friction, u = Friction(12.0, v_b=1.6, law="gaussian"), 1.6 * 0.9
    fall = 12.0 * RIG.r_1 * (0.5 - 0.306)
    assert third_derivative(RIG, friction, 0.9) == pytest.approx(
        fall * 1.6**3 * (12.0 * u - 8.0 * u**3) * np.exp(-u * u), rel=1e-8
    )


@pytest.mark.parametrize(("speed", "grows"), [(0.999, True), (1.001, False)])
def test_a_small_swing_beside_a_hopf_point_of_a_gaussian_fall_does_as_its_criticality_says(speed, grows):
    """Subcritical: what lies just above it dies when small; below it everything grows."""
    friction = Friction(10.0, law="gaussian")
    top = hopf_points(RIG, friction)[-1]
    assert top.criticality == "subcritical"
    reference = float(top.speed_reference) * speed
    start = steady_state(RIG, friction, reference).reshape(7) + 1e-3 * np.eye(7)[2]
    swing = simulate(RIG, friction, start, reference, 400.0, 0.1).bit_speed
    early, late = np.ptp(swing[100:200]), np.ptp(swing[-100:])
    assert (late > early) == grows


def test_the_lower_hopf_point_of_a_gaussian_fall_bears_small_orbits():
    friction = Friction(10.0, law="gaussian")
    low = hopf_points(RIG, friction)[0]
    assert low.criticality == "supercritical"


def test_kink_of_a_linear_fall_is_the_border():
    friction = Friction(10.0, v_b=0.8, law="linear")
    points = hopf_points(RIG, friction)
    assert [(p.label, p.criticality, p.direction) for p in points] == [
        ("H1", "kink", "unstable"),
        ("H2", "kink", "stable"),
    ]
    assert points[1].speed_reference == critical_speed(RIG, friction) == 1.25


@pytest.mark.parametrize("law", LAWS)
def test_stick_slip_ends_where_simulation_says(law):
    friction = Friction(14.0, v_b=0.9, law=law)
    fold = fold_speed(RIG, friction)
    orbit = stick_slip_orbit(RIG, friction, 0.995 * fold)
    assert orbit.stable
    for share, sticks in ((0.999, True), (1.01, False)):
        run = simulate(RIG, friction, orbit.state, share * fold, 250.0, 0.05)
        assert (run.bit_speed[-200:].min() < 0.05 * fold) == sticks


def test_other_law_that_falls_as_good_as_linearly_has_the_exponentials_critical_speed():
    """A fall whose slope at the speed asked for is the exponential's is as stable there."""
    speed = critical_speed(RIG, Friction(10.0))
    slope = Friction(10.0).slope(RIG, speed)
    assert slope == pytest.approx(critical_slope(RIG), rel=1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_speeds_scale_with_the_rig(law):
    torque, time = 37.0, 1.0 / 6.5
    friction, other = Friction(10.0, law=law), Friction(10.0, v_b=time, law=law)
    rig = scaled(time=time, torque=torque)
    assert critical_speed(rig, other) * time == pytest.approx(critical_speed(RIG, friction), rel=1e-10)
    assert fold_speed(rig, other) * time == pytest.approx(fold_speed(RIG, friction), rel=1e-5)


def test_diagram_of_another_law_has_p1_and_says_why_it_has_no_p2():
    diagram = bifurcation_diagram(RIG, Friction(10.0, law="gaussian"), points=6)
    assert diagram.special["fold"] == pytest.approx(fold_speed(RIG, diagram.friction), rel=1e-9)
    assert len(diagram.p1.points) >= 4
    assert "lowest of the speeds asked for" in diagram.p1.begins
    np.testing.assert_allclose(diagram.p1.points["lowest_bit_speed"], 0.0, atol=1e-3)
    assert len(diagram.p2.points) == 0
    assert "exponential law alone" in diagram.p2.begins


@pytest.mark.parametrize("call", [slipping_orbit, force_diagram])
def test_orbits_that_slip_all_the_time_are_refused_under_other_laws(call):
    with pytest.raises(ValueError, match=r"law = 'gaussian' is not allowed; allowed: 'exponential'"):
        call(RIG, Friction(10.0, law="gaussian"), 2.5)
