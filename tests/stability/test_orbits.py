import csv

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.stability import (
    NoOrbitError,
    bifurcation_diagram,
    critical_speed,
    equilibria,
    fold_speed,
    force_diagram,
    hopf_and_fold_curves,
    hopf_points,
    slipping_orbit,
    stick_slip_orbit,
)
from drillrig_env.stability.return_map import ReturnMap
from drillrig_env.stability.slipping_orbits import slipping_orbits

RIG = Rig()
DIAGRAM = bifurcation_diagram(RIG, Friction(10.0), points=100)


@pytest.mark.parametrize(
    ("force", "speed"), [(10.0, 2.0), (10.0, 2.8), (20.0, 2.0), (20.0, 4.0), (40.0, 1.0), (10.0, 0.1)]
)
def test_stick_slip_orbit_sticks_closes_and_is_stable(force, speed):
    orbit = stick_slip_orbit(RIG, Friction(force), speed)
    assert orbit.stuck > 0
    assert orbit.stable
    assert np.abs(orbit.multipliers - 1.0).min() < 2e-3  # the trivial one
    again = ReturnMap(RIG, Friction(force))(orbit.state, speed)
    np.testing.assert_allclose(again.state, orbit.state, atol=1e-6)
    run = simulate(None, Friction(force), orbit.state, speed, duration=3 * orbit.period, sample_period=0.001)
    assert run.bit_speed.max() == pytest.approx(orbit.highest[0], abs=1e-4)


def test_developed_stick_slip_is_as_the_design_says():
    orbit = stick_slip_orbit(RIG, Friction(20.0), 2.0)
    assert orbit.period == pytest.approx(2.4, abs=0.1)
    assert orbit.stuck == pytest.approx(0.2, abs=0.05)
    assert orbit.highest[0] / 2.0 == pytest.approx(2.2, abs=0.15)


@pytest.mark.parametrize("speed", [2.02, 2.3, 2.6, 2.85])
def test_slipping_orbit_never_sticks_closes_and_is_unstable(speed):
    orbit = slipping_orbit(RIG, Friction(10.0), speed)
    assert orbit.speed_reference == pytest.approx(speed, abs=1e-6)
    assert orbit.stuck == 0.0
    assert not orbit.stable
    outside = np.abs(orbit.multipliers) > 1.0 + 1e-3
    assert outside.sum() == 1
    time, states = orbit.trajectory(200)
    np.testing.assert_allclose(states[-1], orbit.state, atol=1e-5)
    assert time[-1] == pytest.approx(orbit.period)
    assert states[:, 2].min() == pytest.approx(orbit.lowest[0], abs=1e-3)


def test_multiplier_of_p2_at_the_fold():
    orbit = slipping_orbit(RIG, Friction(10.0), fold_speed(RIG, Friction(10.0)) - 1e-4)
    assert np.abs(orbit.multipliers).max() == pytest.approx(1.91, abs=0.01)


def test_slipping_orbits_of_all_frictions_are_one_family():
    """A friction with another N_1, spread and decay has the same orbits, scaled by v_b."""
    family = slipping_orbits(RIG)
    for friction in (Friction(10.0), Friction(27.0, 0.55, 0.25, 0.8)):
        border, fold = critical_speed(RIG, friction), fold_speed(RIG, friction)
        orbit = slipping_orbit(RIG, friction, 0.5 * (border + fold))
        depth = friction.v_b * (orbit.speed_reference - orbit.lowest[0])
        assert orbit.period == pytest.approx(2 * np.pi / family.guess(depth)[1], rel=1e-5)


@pytest.mark.parametrize("speed", [2.95, 5.0])
def test_no_stick_slip_above_the_fold(speed):
    with pytest.raises(NoOrbitError, match=r"up to 2\.9009"):
        stick_slip_orbit(RIG, Friction(10.0), speed)


@pytest.mark.parametrize("share", [0.1, 1.0])
def test_within_the_stick_zone_the_sentence_says_so(share):
    with pytest.raises(NoOrbitError, match=r"up to omega_s = 0\.001 rad/s the bit counts as standing.*above that"):
        stick_slip_orbit(RIG, Friction(10.0), share * RIG.omega_s)
    assert stick_slip_orbit(RIG, Friction(10.0), 1.1 * RIG.omega_s).stuck > 0.9


@pytest.mark.parametrize("speed", [1.9, 2.95])
def test_no_slipping_orbit_outside_the_bistable_range(speed):
    with pytest.raises(NoOrbitError, match=r"critical speed 1\.9949.*fold 2\.9009"):
        slipping_orbit(RIG, Friction(10.0), speed)


def test_weak_friction_and_bad_speeds_are_explained():
    with pytest.raises(NoOrbitError, match="never does"):
        stick_slip_orbit(RIG, Friction(0.5), 1.0)
    with pytest.raises(ValueError, match=r"speed_reference = -1.0 rad/s"):
        stick_slip_orbit(RIG, Friction(10.0), -1.0)


def test_hopf_point_h2_is_subcritical_and_transversal():
    for force in (10.0, 20.0):
        kink, point = hopf_points(RIG, Friction(force))
        assert (kink.label, kink.criticality, kink.speed_reference) == ("H1", "kink", RIG.omega_s)
        assert point.criticality == "subcritical"
        assert point.frequency == pytest.approx(2.69399, abs=1e-5)
        step = 1e-5
        sides = [
            max(equilibria(RIG, Friction(force), np.array([point.speed_reference + s]))[0]["eigenvalues"].real)
            for s in (-step, step)
        ]
        assert (sides[1] - sides[0]) / (2 * step) == pytest.approx(point.crossing_speed, rel=1e-4)
    assert hopf_points(RIG, Friction(0.5)) == []


def test_lyapunov_coefficient_agrees_with_the_orbits_near_the_hopf_point():
    """Near H2 the family bends towards smaller gains, so that p2 lies beside the stable steady state."""
    family = slipping_orbits(RIG)
    assert np.all(np.diff(family.log_gain) < 0)


def test_equilibria_change_stability_at_the_special_points_by_both_criteria():
    points = DIAGRAM.equilibria
    border = DIAGRAM.special["H2"]
    inside = np.abs(points["speed_reference"] - border) > 1e-9
    np.testing.assert_array_equal(points["stable"][inside], points["stable_by_eigenvalues"][inside])
    np.testing.assert_array_equal(points["stable"][inside], points["speed_reference"][inside] > border)
    assert set(points["branch"]) == {"e1", "e2"}
    assert equilibria(RIG, Friction(10.0), np.array([5e-4]))[0]["stable"]  # inside the stick zone


def test_diagram_has_its_branches_and_special_points():
    assert DIAGRAM.special["H2"] == pytest.approx(1.994, abs=0.002)
    assert DIAGRAM.special["fold"] == pytest.approx(2.9, abs=0.002)
    p1, p2 = DIAGRAM.p1, DIAGRAM.p2
    assert len(p1.points) == len(p2.points) == 100
    assert p1.points["stable"].all()
    assert not p2.points["stable"][:-1].any()
    assert (p1.points["stuck"] > 0).all()
    assert (p2.points["stuck"][:-1] == 0).all()
    assert p2.points["speed_reference"][0] == pytest.approx(DIAGRAM.special["H2"], abs=1e-3)
    for branch in (p1, p2):
        assert branch.points["speed_reference"][-1] == pytest.approx(DIAGRAM.special["fold"], abs=1e-3)
        assert "fold" in branch.ends
    assert p1.points["highest_bit_speed"][-1] == pytest.approx(p2.points["highest_bit_speed"][-1], abs=2e-3)
    trivial = np.abs(np.concatenate([p1.points, p2.points])["multipliers"] - 1.0).min(axis=1)
    assert trivial.max() < 0.02


def test_tables_and_csv(tmp_path):
    table = DIAGRAM.p2.table()
    assert {"speed_reference", "period", "stuck", "lowest_bit_speed", "highest_current", "multiplier_7"} <= set(table)
    DIAGRAM.p2.to_csv(tmp_path / "p2.csv")
    rows = list(csv.DictReader((tmp_path / "p2.csv").open()))
    assert len(rows) == 100
    assert float(rows[3]["period"]) == table["period"][3]


def test_weak_friction_gives_an_empty_diagram_that_says_why():
    diagram = bifurcation_diagram(RIG, Friction(0.5), points=10)
    assert len(diagram.p1.points) == 0
    assert "no stick-slip" in diagram.p1.ends
    assert diagram.special == {}
    assert diagram.equilibria["stable"].all()


def test_branches_over_the_normal_force_meet_where_the_speed_is_the_fold():
    p1, p2 = force_diagram(RIG, Friction(30.0), 3.0, points=30)
    np.testing.assert_allclose(p2.points["speed_reference"], 3.0, atol=1e-6)
    force = p2.points["normal_force"][-1]
    assert fold_speed(RIG, Friction(force)) == pytest.approx(3.0, abs=1e-6)
    assert critical_speed(RIG, Friction(p2.points["normal_force"][0])) == pytest.approx(3.0, abs=1e-2)
    assert p1.points["normal_force"][[0, -1]] == pytest.approx([30.0, force], rel=1e-3)
    assert p1.points["stable"].all()


def test_two_parameter_curves():
    curves = hopf_and_fold_curves(RIG, Friction(), np.array([0.5, 10.0, 20.0]))
    assert curves["critical_speed"] == pytest.approx([0.0, 1.9949, 2.6881], abs=1e-4)
    assert np.isnan(curves["fold_speed"][0])
    assert curves["fold_speed"][1:] == pytest.approx([2.90097, 4.78551], abs=1e-5)


def test_heavy_loads_have_their_slipping_orbits_too():
    """Beyond the depth that the family is first followed to."""
    friction = Friction(90.0)
    border, fold = critical_speed(RIG, friction), fold_speed(RIG, friction)
    assert fold > 12.0 + RIG.omega_s
    orbit = slipping_orbit(RIG, friction, fold - 0.05)
    assert orbit.speed_reference == pytest.approx(fold - 0.05, abs=1e-5)
    assert orbit.lowest[0] < 0.2
    assert border < orbit.speed_reference


@pytest.mark.parametrize(
    "analysis",
    [lambda f: hopf_points(RIG, f), lambda f: bifurcation_diagram(RIG, f), lambda f: stick_slip_orbit(RIG, f, 2.0)],
)
def test_a_batch_is_refused_where_one_friction_is_meant(analysis):
    with pytest.raises(ValueError, match="number of rigs = 2"):
        analysis(Friction(np.array([10.0, 20.0])))
