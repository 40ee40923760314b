"""Equilibria and Hopf points against the simulation, and against the orbits that are born at them."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.model import jacobian, state_equations
from drillrig_env.stability import critical_slope, critical_speed, equilibria, hopf_points
from drillrig_env.stability.equilibria import HopfPoint
from drillrig_env.stability.slipping_orbits import slipping_orbits

RIGS = [Rig(), Rig(k_p=1.5, d_1=0.03, J_1=0.04)]


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("v_b", [1.0, 0.7])
def test_lyapunov_coefficient_gives_the_swing_of_the_orbits_near_the_hopf_point(rig, v_b):
    """On the orbit crossing_speed (omega_ref - omega_c) + frequency l_1 |z|^2 = 0, and x_3 swings by 2 |z| |q_3|.

    The orbits come from harmonic balance, which knows nothing of normal forms; q is the unit eigenvector.
    """
    point = hopf_points(rig, Friction(20.0, v_b=v_b))[1]
    values, modes = np.linalg.eig(jacobian(rig, critical_slope(rig)))
    pair = int(np.argmin(np.abs(values - 1j * point.frequency)))
    wave, _, log_gain = slipping_orbits(rig).orbit(0.02)
    beyond = (np.log(-critical_slope(rig)) - log_gain) / v_b  # omega_ref - omega_c
    square = -point.crossing_speed * beyond / (point.frequency * point.lyapunov_coefficient)
    swing = 2.0 * np.abs(np.fft.rfft(wave)[1]) / len(wave) / v_b  # of the first harmonic
    assert 2.0 * np.sqrt(square) * abs(modes[2, pair]) == pytest.approx(swing, rel=1e-4)


def test_lyapunov_coefficient_scales_with_the_square_of_the_decay_factor():
    """q = v_b (x_3 - omega) obeys one equation for every friction, so l_1 grows with v_b^2, whatever the load."""
    points = [hopf_points(Rig(), Friction(force, v_b=v_b))[1] for force, v_b in ((10.0, 1.0), (30.0, 1.0), (20.0, 1.3))]
    coefficients = [point.lyapunov_coefficient for point in points]
    assert coefficients == pytest.approx(coefficients[0] * np.array([1.0, 1.0, 1.69]), rel=1e-6)
    assert [point.crossing_speed for point in points] == pytest.approx(
        points[0].crossing_speed * np.array([1.0, 1.0, 1.3]), rel=1e-6
    )


@pytest.mark.parametrize(("coefficient", "name"), [(0.1, "subcritical"), (-0.1, "supercritical"), (np.nan, "kink")])
def test_sign_of_the_coefficient_names_the_point(coefficient, name):
    assert HopfPoint("H2", 2.0, 2.7, -0.1, coefficient).criticality == name


def test_points_of_the_branches_stand_still_and_carry_their_eigenvalues():
    rig, friction = Rig(T_r2=0.05), Friction(10.0)
    border = critical_speed(rig, friction)
    points = equilibria(rig, friction, np.array([0.5, border - 1e-3, border + 1e-3, 4.0]))
    assert points["branch"].tolist() == ["e1", "e1", "e2", "e2"]
    assert points["stable"].tolist() == [False, False, True, True] == points["stable_by_eigenvalues"].tolist()
    for point in points:
        speed = float(point["speed_reference"])
        T_r1 = friction.torque(rig, speed)
        np.testing.assert_allclose(state_equations(point["state"], speed, T_r1, rig), 0.0, atol=1e-9)
        np.testing.assert_allclose(
            np.sort_complex(point["eigenvalues"]),
            np.sort_complex(np.linalg.eigvals(jacobian(rig, friction.slope(rig, speed)))),
            atol=1e-9,
        )


def test_pair_that_crosses_is_how_a_nudged_rig_swings():
    point = hopf_points(Rig(), Friction(10.0))[1]
    state = equilibria(Rig(), Friction(10.0), np.array([point.speed_reference]))[0]["state"].copy()
    state[2] += 1e-3
    run = simulate(None, Friction(10.0), state, point.speed_reference, duration=40.0, sample_period=0.01)
    swing = run.bit_speed[1000:] - point.speed_reference
    rises = run.time[1000:-1][(swing[:-1] < 0) & (swing[1:] >= 0)]
    assert 2 * np.pi / np.diff(rises).mean() == pytest.approx(point.frequency, rel=1e-3)
    assert np.ptp(swing[-300:]) == pytest.approx(np.ptp(swing[:300]), rel=0.02)  # neither grows nor dies


@pytest.mark.parametrize(("speed", "count"), [(5e-4, 0), (1.5e-3, 2), (0.02, 2)])
def test_hopf_points_exist_where_the_critical_speed_leaves_the_stick_zone(speed, count):
    force = -critical_slope(Rig()) * np.exp(speed) / (0.0485 * 0.194)
    assert critical_speed(Rig(), Friction(force)) == pytest.approx(speed, rel=1e-6)
    assert len(hopf_points(Rig(), Friction(force))) == count


def test_rig_that_is_never_stable_has_no_hopf_point():
    assert hopf_points(Rig(k_p=0.0, k_i=5.0, K_E=0.0, C_m=0.0), Friction(10.0)) == []
