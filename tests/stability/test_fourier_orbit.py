"""Slipping orbits of rigs of every size: that they close, their multipliers against differences of the flow."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.stability import bifurcation_diagram, critical_speed, fold_speed, slipping_orbit
from drillrig_env.stability.limit_cycle import slipping_orbit_of_depth
from drillrig_env.stability.slipping_orbits import slipping_orbits
from drillrig_env.stepper.batch import advance_batch
from drillrig_env.stepper.units import units_of
from tests.rigs import FAST, FIELD, SOFT

RIG = Rig()
CASES = {
    "chapter": (RIG, Friction(14.0, v_b=1.1)),
    "soft drive": (SOFT, Friction(12.0)),
    "laboratory": (FAST, Friction(10.0, v_b=1.0 / 6.5)),
    "field": (FIELD, Friction(9000.0, 1.0, 0.6, 0.2)),
}


def after(rig, friction, orbit, states, turns=1):
    """States some periods on, by the stepper."""
    periods = 64 * turns
    return advance_batch(
        rig,
        friction,
        states,
        orbit.speed_reference,
        period=orbit.period * turns / periods,
        periods=periods,
        every=periods,
        tolerance=1e-7,
    )[:, 0]


def middle_of(rig, friction):
    return 0.5 * (critical_speed(rig, friction) + fold_speed(rig, friction))


@pytest.mark.parametrize(("rig", "friction"), CASES.values(), ids=CASES)
def test_multipliers_agree_with_differences_of_the_flow(rig, friction):
    orbit = slipping_orbit(rig, friction, middle_of(rig, friction))
    units = units_of(rig).states
    np.testing.assert_allclose(
        after(rig, friction, orbit, orbit.state[None])[0] / units, orbit.state / units, atol=1e-6
    )
    steps = 1e-5 * np.diag(units)
    ends = after(rig, friction, orbit, np.concatenate([orbit.state + steps, orbit.state - steps])) / units
    values = np.linalg.eigvals((ends[:7] - ends[7:]).T / 2e-5)
    largest = np.sort(np.abs(values))[::-1][:3]
    np.testing.assert_allclose(np.abs(orbit.multipliers[:3]), largest, rtol=1e-5)
    assert largest[0] > 1.001
    assert 1.0 in orbit.multipliers
    assert not orbit.stable


@pytest.mark.parametrize(("force", "multiplier"), [(4.0, 1.160260), (5.0, 1.257884), (7.0, 1.486725), (10.0, 1.907799)])
def test_the_grazing_orbit_keeps_the_multiplier_of_those_that_slip(force, multiplier):
    """On its way there the multiplier is smooth; differences of the flow would enter the stick zone."""
    friction = Friction(force)
    fold = fold_speed(RIG, friction)
    grazing = slipping_orbit(RIG, friction, fold)
    assert grazing.multipliers[0].real == pytest.approx(multiplier, abs=1e-5)
    near = [abs(slipping_orbit(RIG, friction, fold * (1.0 - share)).multipliers[0]) for share in (2e-4, 1e-4)]
    assert 2 * near[1] - near[0] == pytest.approx(multiplier, abs=2e-4)
    assert not grazing.stable


@pytest.mark.parametrize(("rig", "friction"), CASES.values(), ids=CASES)
@pytest.mark.parametrize("share", [1e-6, 1e-4, 1e-2])
def test_orbits_as_shallow_as_a_millionth_of_the_speed(rig, friction, share):
    border = critical_speed(rig, friction)
    depth = share * friction.v_b * border
    orbit = slipping_orbit_of_depth(slipping_orbits(rig), friction, depth)
    swing = orbit.speed_reference - orbit.lowest[0]
    assert swing == pytest.approx(share * border, rel=1e-6)
    assert orbit.highest[0] - orbit.speed_reference == pytest.approx(swing, rel=3 * friction.v_b * swing + 1e-6)
    assert orbit.speed_reference == pytest.approx(border, rel=max(share, 1e-9))
    assert not orbit.stable


def test_multiplier_of_shallow_orbits_grows_with_the_square_of_the_swing():
    friction = Friction(10.0)
    small, large = (
        slipping_orbit_of_depth(slipping_orbits(RIG), friction, depth).multipliers[0].real - 1.0
        for depth in (1e-3, 2e-3)
    )
    assert large / small == pytest.approx(4.0, rel=1e-4)


@pytest.mark.parametrize("distance", [1e-7, 1e-5, 1e-3])
def test_slipping_orbit_close_to_the_hopf_point(distance):
    friction = Friction(15.0, v_b=0.9)
    speed = critical_speed(RIG, friction) + distance
    orbit = slipping_orbit(RIG, friction, speed)
    assert orbit.speed_reference == pytest.approx(speed, abs=1e-8)
    assert 1.0 < orbit.multipliers[0].real < 1.01


def test_extremes_are_those_of_a_fine_trajectory_and_the_state_lies_on_the_section():
    orbit = slipping_orbit(RIG, Friction(20.0), 3.4)
    _, states = orbit.trajectory(4000)
    np.testing.assert_allclose(orbit.lowest, states[:, 2:6].min(axis=0), atol=1e-5)
    np.testing.assert_allclose(orbit.highest, states[:, 2:6].max(axis=0), atol=1e-5)
    assert orbit.state[2] == pytest.approx(orbit.speed_reference, abs=1e-12)
    assert states[1, 2] > states[0, 2]


@pytest.mark.parametrize("points", [10, 400, pytest.param(5000, marks=pytest.mark.slow)])
def test_diagrams_have_the_points_asked_for_each_with_its_stability(points):
    diagram = bifurcation_diagram(RIG, Friction(12.0), points=points)
    assert len(diagram.p1.points) == len(diagram.p2.points) == points
    assert diagram.p1.points["stable"].all()
    assert not diagram.p2.points["stable"].any()


@pytest.mark.parametrize("force", [1.4, 2.5, 300.0])
def test_diagrams_of_light_and_heavy_loads(force):
    p2 = bifurcation_diagram(RIG, Friction(force), points=12).p2.points
    assert len(p2) == 12
    assert not p2["stable"].any()
    assert bifurcation_diagram(RIG, Friction(0.01), points=12).special == {}
