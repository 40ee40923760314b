"""Modes that have died out: without inductance, collars' inertia or a soft upper shaft the rig is a smaller one."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from drillrig_env import Friction, Rig, simulate
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms

FRICTION, SPEED, TIMES = Friction(16.0, 0.45, 0.28, 1.2), 2.4, np.arange(0.0, 4.01, 0.5)
START = np.array([0.0, 0.0, 2.4, 2.4, 2.4, 0.5, 0.0])


def split_radau(rates, state, bit):
    """A smaller model piece by piece of (4-9); `rates(state, T_r1)`, `bit` the place of the bit speed."""
    rig = Rig()
    static, kinetic = (FRICTION.normal_force * rig.r_1 * mu for mu in (FRICTION.mu_s, FRICTION.mu_k))

    def torque(zone, x):
        falling = (static - kinetic) * np.exp(-FRICTION.v_b * zone * x)
        return static * x / rig.omega_s if zone == 0 else zone * (kinetic + falling)

    states, time, zone = [np.array(state)], 0.0, 1
    while len(states) < len(TIMES):
        events = []
        for side in (-1, 1) if zone == 0 else (zone,):
            event = lambda _t, x, side=side: x[bit] - side * rig.omega_s  # noqa: E731
            event.terminal, event.direction = True, side if zone == 0 else -side
            events.append(event)
        piece = solve_ivp(
            lambda _t, x, zone=zone: rates(x, torque(zone, x[bit])),
            (time, TIMES[-1]),
            state,
            "Radau",
            t_eval=TIMES[len(states) :],
            events=events,
            rtol=1e-9,
            atol=1e-11,
        )
        states.extend(np.reshape(piece.y, (len(state), -1)).T)
        if piece.status == 1:
            hit = next(k for k, found in enumerate(piece.t_events) if len(found))
            time, state = piece.t_events[hit][0], piece.y_events[hit][0]
            zone = 0 if zone != 0 else (-1, 1)[hit]
    return np.array(states)


def without_inductance(x, T_r1):
    p = Rig()
    current = (p.k_p * (SPEED - x[4]) + p.k_i * x[5] - p.eta * p.K_E * x[4]) / p.R
    return [
        x[2] - x[3],
        x[3] - x[4],
        (-p.d_1 * (x[2] - x[3]) - p.k_1 * x[0] - T_r1) / p.J_1,
        (p.d_1 * (x[2] - x[3]) - p.d_2 * (x[3] - x[4]) + p.k_1 * x[0] - p.k_2 * x[1]) / p.J_2,
        (p.k_2 * x[1] + p.d_2 * (x[3] - x[4]) - p.eta**2 * p.C_m * x[4] + p.eta * (p.K_T * current - p.T_f)) / p.J_3,
        SPEED - x[4],
    ]


def with_discs_as_one(x, T_r1):
    """Discs 1 and 2 on a rigid shaft."""
    p = Rig()
    return [
        x[1] - x[2],
        (-p.k_2 * x[0] - p.d_2 * (x[1] - x[2]) - T_r1) / (p.J_1 + p.J_2),
        (p.k_2 * x[0] + p.d_2 * (x[1] - x[2]) - p.eta**2 * p.C_m * x[2] + p.eta * (p.K_T * x[3] - p.T_f)) / p.J_3,
        (-p.R * x[3] - p.eta * p.K_E * x[2] + p.k_p * (SPEED - x[2]) + p.k_i * x[4]) / p.L,
        SPEED - x[2],
    ]


def speeds(rig, sample_period=0.1):
    run = simulate(rig, FRICTION, START, SPEED, duration=TIMES[-1], sample_period=sample_period)
    return run.state[:: round(0.5 / sample_period), 2:5]


@pytest.fixture(scope="module")
def motor_without_lag():
    """Speeds of the three discs."""
    return split_radau(without_inductance, np.delete(START, 5), 2)[:, 2:5]


@pytest.fixture(scope="module")
def two_discs():
    """Speeds of the lower one."""
    return split_radau(with_discs_as_one, np.delete(START, [0, 3]), 1)[:, 1]


@pytest.mark.parametrize("sample_period", [0.1, 0.5, 0.02])
def test_inductance_that_vanishes_leaves_the_motor_without_lag(motor_without_lag, sample_period):
    errors = [np.abs(speeds(Rig(L=L), sample_period) - motor_without_lag).max() for L in (2e-5, 2e-6, 2e-8, 3e-10)]
    assert errors[0] < 0.1
    assert errors[1] < 0.2 * errors[0]
    assert errors[3] < errors[2] < 2e-6


@pytest.mark.parametrize("changes", [{"d_1": 2e5}, {"d_1": 2e6}])
def test_damping_that_grows_makes_one_disc_of_two(two_discs, changes):
    assert np.abs(speeds(replace(Rig(), **changes))[:, 0] - two_discs).max() < 2e-5


@pytest.mark.parametrize(
    "rig", [Rig(L=3e-5), Rig(R=7.0, k_i=20.0), Rig(J_2=2e-6), Rig(d_1=300.0), Rig(k_1=400.0), Rig(L=2e-7, J_2=4e-5)]
)
def test_long_and_short_sample_periods_agree(rig):
    np.testing.assert_allclose(speeds(rig, 0.5), speeds(rig, 0.005), atol=1e-6)


@pytest.mark.parametrize("changes", [{"L": 4e-5}, {"L": 5e-9}, {"R": 4.0, "L": 2e-4, "k_p": 20.0, "k_i": 9.0}])
def test_environment_steps_such_a_rig_as_the_simulation_does(changes):
    rig = replace(Rig(), **changes)
    core = EpisodeBatch(1, rig=rig, scenario="nominal")
    core.reset(np.array([0]), first_uniforms(0, 1), {"normal_force": 23.0, "speed_target": 2.2, "start": "stick_slip"})
    start = core.episodes["state"][0, :7].copy()
    friction = Friction(23.0, *(float(core.episodes[name][0]) for name in ("mu_s", "mu_k", "v_b")))
    run = simulate(rig, friction, start, float(core.episodes["speed_reference"][0]), duration=5.0, sample_period=0.02)
    assert np.abs(run.bit_speed).max() < 7.0
    for step in range(1, 51):
        core.step(np.zeros((1, 1), dtype=np.float32))
        np.testing.assert_allclose(core.episodes["state"][0, 2:5], run.state[5 * step, 2:5], atol=1e-6)


def test_flat_friction_far_from_its_fall_is_not_taken_for_flat_all_the_way():
    """Friction that has long fallen says nothing of how it rises where the bit slows down."""
    friction, start = Friction(60.0, 0.6, 0.2, 30.0), np.array([0.0, 0.0, 4.0, 1.0, 1.0, 0.5, 0.0])
    runs = [
        simulate(None, friction, start, 1.0, duration=2.0, sample_period=period).state[:: round(0.1 / period), 2:5]
        for period in (0.1, 0.0025)
    ]
    np.testing.assert_allclose(*runs, atol=1e-6)
