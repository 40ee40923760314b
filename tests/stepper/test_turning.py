"""A tilted disc: the fast stepper against SciPy, with theta_1 as a state of its own there."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from drillrig_env import Friction, Rig, Tilt, simulate
from drillrig_env.model import state_equations
from tests.rigs import FAST, scaled

TIMES = np.linspace(0.0, 8.0, 41)


def eight_states(rig, friction, tilt, speed, start):
    """The model piece by piece of (4-9), theta_1 the eighth state; sampled at TIMES."""
    static, kinetic = (friction.normal_force * rig.r_1 * mu for mu in (friction.mu_s, friction.mu_k))

    def torque(zone, x_3):
        falling = (static - kinetic) * np.exp(-friction.v_b * zone * x_3)
        return static * x_3 / rig.omega_s if zone == 0 else zone * (kinetic + falling)

    def rates(_t, x, zone):
        press = 1.0 + tilt.share * np.cos(tilt.turns[0] * x[7] + tilt.phase)
        return [*state_equations(x[:7], speed, press * torque(zone, x[2]), rig), x[2]]

    states, time, state, zone = [np.array([*start, 0.0])], 0.0, np.array([*start, 0.0]), 1 if start[2] > 0 else 0
    while len(states) < len(TIMES):
        events = []
        for side in (-1, 1) if zone == 0 else (zone,):
            event = lambda _t, x, _zone, side=side: x[2] - side * rig.omega_s  # noqa: E731
            event.terminal, event.direction = True, side if zone == 0 else -side
            events.append(event)
        span, tolerances = (time, TIMES[-1]), {"rtol": 1e-9, "atol": 1e-11}
        piece = solve_ivp(rates, span, state, "Radau", TIMES[len(states) :], events=events, args=(zone,), **tolerances)
        states.extend(np.reshape(piece.y, (8, -1)).T)
        if piece.status == 1:
            hit = next(k for k, found in enumerate(piece.t_events) if len(found))
            time, state = piece.t_events[hit][0], piece.y_events[hit][0]
            state[2] = (-1, 1)[hit] * rig.omega_s if zone == 0 else zone * rig.omega_s
            zone = 0 if zone != 0 else (-1, 1)[hit]
    return np.array(states)


@pytest.mark.parametrize(
    ("rig", "force", "speed", "tilt"),
    [
        (Rig(), 10.0, 2.5, Tilt(0.1, 1, 0.3)),
        (Rig(), 22.0, 3.0, Tilt(0.1, 2)),
        (Rig(), 18.0, 1.1, Tilt(1.0, 3, -2.0)),
        (Rig(), 30.0, 7.0, Tilt(0.4, 16, 1.0)),
        (Rig(J_1=0.06, k_1=0.9, L=1e-5), 14.0, 3.0, Tilt(0.25, 4, 0.7)),
        (Rig(omega_s=0.3), 20.0, 2.0, Tilt(1.0, 5)),  # the disc turns far while it settles in the stick zone
        (Rig(omega_s=0.3), 20.0, 2.0, Tilt(0.3, 2)),
    ],
)
def test_fast_stepper_agrees_with_radau_on_eight_states(rig, force, speed, tilt):
    friction = Friction(force)
    start = np.array([0.0, 0.0, speed, speed, speed, 0.5, 0.0])
    run = simulate(rig, friction, start, speed, TIMES[-1], TIMES[1], tilt=tilt)
    expected = eight_states(rig, friction, tilt, speed, start)
    np.testing.assert_allclose(run.state, expected[:, :7], atol=1e-6)
    press = force * (1.0 + tilt.share * np.cos(tilt.turns[0] * expected[:, 7] + tilt.phase))
    np.testing.assert_allclose(run.normal_force, press, atol=2e-5 * force)
    assert np.ptp(press) > tilt.share * force  # the disc has turned far enough to tell


@pytest.mark.usefixtures("coarser_radau")
def test_reference_methods_follow_a_tilt_too():
    arguments = {"speed_reference": [(0, 2.0), (1.3, 3.0)], "duration": 4.0, "sample_period": 0.2, "tilt": Tilt(0.5, 2)}
    fast, radau, vode = (simulate(method=method, **arguments).state for method in ("fast", "radau", "vode"))
    np.testing.assert_allclose(fast, radau, atol=1e-6)
    np.testing.assert_allclose(vode, radau, atol=1e-3)


def test_time_may_run_faster():
    tilt, arguments = Tilt(0.3, 2, 0.4), {"duration": 6.5, "sample_period": 0.13}
    slow = simulate(None, Friction(20.0), None, 3.0, tilt=tilt, **arguments)
    quick = simulate(FAST, Friction(20.0, v_b=1 / 6.5), None, 19.5, 1.0, 0.02, tilt=tilt)
    # The angle turned in the same share of a period is the same, so that the press is, too.
    np.testing.assert_allclose(quick.bit_speed, 6.5 * slow.bit_speed, atol=2e-5)
    np.testing.assert_allclose(quick.normal_force, slow.normal_force, atol=1e-3)


def test_torques_may_be_larger():
    tilt, times = Tilt(0.3, 2, 0.4), {"duration": 6.0, "sample_period": 0.1}
    plain = simulate(None, Friction(20.0), None, 3.0, tilt=tilt, **times)
    strong = simulate(scaled(torque=2.0**20), Friction(20.0), None, 3.0, tilt=tilt, **times)
    np.testing.assert_array_equal(strong.bit_speed, plain.bit_speed)


def test_no_tilt_is_a_disc_that_turns_true_bit_for_bit():
    plain = simulate(friction=Friction(20.0), speed_reference=3.0, duration=10.0)
    np.testing.assert_array_equal(simulate(None, Friction(20.0), None, 3.0, 10.0, tilt=Tilt(0.0)).state, plain.state)
    slight = simulate(None, Friction(20.0), None, 3.0, 10.0, tilt=Tilt(1e-9))
    np.testing.assert_allclose(slight.state, plain.state, atol=1e-6)


def test_a_full_turn_of_the_phase_changes_nothing():
    runs = [
        simulate(friction=Friction(20.0), speed_reference=3.0, duration=5.0, tilt=Tilt(0.2, 3, phase)).state
        for phase in (0.7, 0.7 + 2.0 * np.pi)
    ]
    np.testing.assert_allclose(*runs, atol=1e-9)


def test_samples_may_be_taken_at_any_distance():
    tilt = Tilt(0.4, 3, 0.2)
    coarse, fine = (simulate(None, Friction(20.0), None, 3.0, 6.0, period, tilt=tilt) for period in (0.3, 0.05))
    np.testing.assert_allclose(coarse.state, fine.state[::6], atol=1e-6)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"share": 1.2}, "share = 1.2 is not allowed; allowed: >= 0 and <= 1"),
        ({"turns": -1}, "turns = -1 is not allowed; allowed: whole, >= 0 and <= 64"),
        ({"turns": (1, 2.5)}, r"turns = 2.5 is not allowed; allowed: whole"),
        ({"turns": ()}, "one number or several"),
        ({"phase": np.nan}, "phase = nan rad is not allowed"),
    ],
)
def test_what_is_no_tilt_is_refused(fields, words):
    with pytest.raises(ValueError, match=words):
        Tilt.of(fields)
