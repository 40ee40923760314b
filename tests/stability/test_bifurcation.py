"""Branches: their spacing, why they end, and what is refused."""

import inspect

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.stability import (
    NoOrbitError,
    bifurcation_diagram,
    end_of_stick_slip,
    fold_speed,
    force_diagram,
    stick_slip_orbit,
)
from drillrig_env.stability.bifurcation import slipping_branch, sticking_branch
from drillrig_env.stability.orbit import PeriodicOrbit
from drillrig_env.stability.vibration_map import load_step_margin, simulated_map

RIG = Rig()


def test_sticking_branch_ends_at_the_fold_when_it_is_asked_for_more():
    fold = fold_speed(RIG, Friction(10.0))
    branch = sticking_branch(RIG, Friction(10.0), np.array([1.0, 2.0, 2.5, fold + 0.1, fold + 0.2]))
    assert branch.points["speed_reference"].tolist() == [1.0, 2.0, 2.5]
    assert "does not stick and slip" in branch.ends
    assert branch.begins == "the lowest speed asked for"
    near = sticking_branch(RIG, Friction(10.0), np.array([2.5, fold * (1 - 1e-4)]))
    assert near.ends.startswith("the fold")
    short = sticking_branch(RIG, Friction(10.0), np.array([2.0, fold * (1 - 3e-4)]))
    assert short.ends == "the highest speed asked for"


def test_points_of_a_branch_are_the_orbits_one_at_a_time():
    point = sticking_branch(RIG, Friction(20.0), np.array([1.0, 2.0]))
    orbit = stick_slip_orbit(RIG, Friction(20.0), 2.0)
    record = point.points[1]
    assert record["normal_force"] == 20.0
    assert record["period"] == pytest.approx(orbit.period, abs=1e-6)
    assert record["stuck"] == pytest.approx(orbit.stuck, abs=2e-3)
    assert record["highest_bit_speed"] == pytest.approx(orbit.highest[0], abs=1e-4)
    assert record["lowest_current"] == pytest.approx(orbit.lowest[3], abs=1e-4)
    assert record["stable"]
    assert abs(record["multipliers"][0] - 1.0) < 5e-3


def test_each_orbit_is_looked_for_from_the_last_on_its_own_section(monkeypatch):
    """A guess leads to its orbit in a few returns; that it was a good one shows in nothing else."""
    guesses = []

    def watched(rig, friction, speed, guess=None):
        guesses.append(guess)
        return stick_slip_orbit(rig, friction, speed, guess)

    monkeypatch.setattr("drillrig_env.stability.bifurcation.stick_slip_orbit", watched)
    speeds = [1.0, 1.1, 1.3, 1.6]
    sticking_branch(RIG, Friction(20.0), np.array(speeds))
    assert guesses[0] is None
    states = [stick_slip_orbit(RIG, Friction(20.0), speed).state for speed in speeds]
    for guess, last, speed in zip(guesses[1:], states, speeds[1:], strict=False):
        assert guess[2] == pytest.approx(speed, abs=1e-9)
        np.testing.assert_allclose(np.delete(guess, 2), np.delete(last, 2), atol=1e-5)

    guesses.clear()
    points = force_diagram(RIG, Friction(20.0), 2.5, points=4)[0].points
    states = [stick_slip_orbit(RIG, Friction(float(force)), 2.5).state for force in points["normal_force"]]
    assert guesses[0] is None
    for guess, last in zip(guesses[1:], states, strict=False):
        np.testing.assert_allclose(guess, last, atol=1e-5)


def test_slipping_branch_is_equally_spaced_in_its_depth():
    friction = Friction(10.0, v_b=1.2)
    branch = slipping_branch(RIG, friction, points=8)
    depths = 1.2 * (branch.points["speed_reference"] - branch.points["lowest_bit_speed"])
    np.testing.assert_allclose(depths, depths[-1] * np.arange(1, 9) / 8, rtol=1e-4)
    assert branch.points["speed_reference"][-1] == pytest.approx(fold_speed(RIG, friction), abs=1e-6)
    assert "H2" in branch.begins
    assert "fold" in branch.ends


def test_diagram_covers_its_speeds_closely_spaced_near_the_fold():
    diagram = bifurcation_diagram(RIG, Friction(10.0), points=6, speeds=(0.5, 4.0))
    speeds = diagram.equilibria["speed_reference"]
    assert (speeds[0], speeds[-1]) == (0.5, 4.0)
    assert diagram.special["H2"] in speeds
    assert len(speeds) == 13
    followed = diagram.p1.points["speed_reference"]
    assert followed[0] == 0.5
    assert followed[-1] == pytest.approx(0.5 + (diagram.special["fold"] - 0.5) * (1 - 1e-4), rel=1e-9)
    assert np.all(np.diff(followed, 2) < 0)  # ever closer
    assert set(diagram.special) == {"H1", "H2", "fold"}


def test_branches_over_the_normal_force_have_their_points_in_order():
    p1, p2 = force_diagram(RIG, Friction(20.0), 2.5, points=5)
    assert len(p1.points) == len(p2.points) == 5
    assert np.all(np.diff(p1.points["normal_force"]) < 0)
    assert np.all(np.diff(p2.points["normal_force"]) < 0)
    assert (p1.points["speed_reference"] == 2.5).all()
    lowest = p2.points["lowest_bit_speed"]
    np.testing.assert_allclose(np.diff(lowest), np.diff(lowest)[0], rtol=1e-3)


def test_force_diagram_without_stick_slip_says_up_to_where():
    with pytest.raises(NoOrbitError, match=r"no orbit up to 5 N at 4 rad/s: the fold is 1\.60828"):
        force_diagram(RIG, Friction(5.0), 4.0)
    with pytest.raises(NoOrbitError, match=r"no orbit up to 0\.5 N"):
        force_diagram(RIG, Friction(0.5), 1.0)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"points": 1}, "points = 1 "),
        ({"speeds": (1.0, 1.0)}, r"speeds = \(1.0, 1.0\) rad/s"),
        ({"speeds": (0.0, 1.0)}, "speeds"),
        ({"speeds": (2.0, 1.0)}, "speeds"),
    ],
)
def test_impossible_diagrams_are_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        bifurcation_diagram(RIG, Friction(10.0), **arguments)


def test_two_points_are_the_fewest():
    diagram = bifurcation_diagram(RIG, Friction(10.0), points=2, speeds=(1.0, 4.0))
    fold = fold_speed(RIG, Friction(10.0))
    assert diagram.p1.points["speed_reference"].tolist() == pytest.approx([1.0, fold], abs=2e-4)
    assert diagram.p1.ends.startswith("the fold")
    assert len(diagram.p2.points) == 2
    assert len(diagram.equilibria) == 5  # H2 among them


@pytest.mark.parametrize(
    ("function", "defaults"),
    [
        (bifurcation_diagram, {"points": 120, "speeds": (0.02, 5.0)}),
        (slipping_branch, {"points": 120}),
        (force_diagram, {"points": 60}),
        (PeriodicOrbit.trajectory, {"samples": 400}),
        (load_step_margin, {"largest_step": None, "duration": None, "halvings": 8}),
        (simulated_map, {"duration": None}),
    ],
)
def test_figures_are_as_fine_and_reach_as_far_as_they_say(function, defaults):
    parameters = inspect.signature(function).parameters
    assert {name: parameters[name].default for name in defaults} == defaults


def test_at_a_heavy_load_p1_goes_on_above_the_fold():
    diagram = bifurcation_diagram(RIG, Friction(90.0), points=25)
    p1, p2, special = diagram.p1.points, diagram.p2.points, diagram.special
    assert special["end"] > 1.003 * special["fold"]
    assert p1["speed_reference"][-1] == pytest.approx(special["end"], rel=2e-4)
    assert p1["stable"].all()
    assert p1["stuck"].min() > 0.02
    assert "unstable one that sticks" in diagram.p1.ends
    assert p2["speed_reference"][-1] == pytest.approx(special["fold"], abs=1e-6)


def test_friction_that_falls_within_the_stick_zone_has_p1_alone():
    diagram = bifurcation_diagram(RIG, Friction(10.0, v_b=3e4), points=40)
    assert len(diagram.p1.points) > 35
    assert diagram.p1.points["stable"].all()
    assert len(diagram.p2.points) == 0
    assert "within the stick zone" in diagram.p2.ends


def test_over_the_normal_force_p1_goes_on_to_lighter_loads_than_p2():
    p1, p2 = force_diagram(RIG, Friction(110.0), 13.5, points=12)
    lightest = p1.points["normal_force"][-1]
    assert lightest < 0.998 * p2.points["normal_force"][-1]
    assert end_of_stick_slip(RIG, Friction(lightest)).speed == pytest.approx(13.5, rel=2e-4)
    assert p1.points["stable"].all()
