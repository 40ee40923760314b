"""One step of each law from made-up measurements, where the wanted reference can be worked out by hand."""

import numpy as np
import pytest

from baselines import Constant, FeedForwardStart, JumpEaseEstimated, SoftTorque, SpeedPulse, ZTorque
from baselines.mppi import KNOTS, MPPI, _coloured, _named
from baselines.set_point_feedback import SetPointFeedback, wanted_change
from drillrig_env import Friction, Rig
from drillrig_env.model import STATE_NAMES, steady_state
from drillrig_env.stability import critical_speed

RIG = Rig()


def seen_by(policy, **values):
    """Physical values of every channel of a policy's sensors, 0 unless given, of one rig."""
    return {name: np.array([float(values.get(name, 0.0))]) for name in policy.sensors.names}


@pytest.mark.parametrize("policy", [Constant(), SoftTorque()], ids=["constant", "soft_torque"])
def test_who_leaves_the_reference_alone_wants_the_target(policy):
    seen = seen_by(policy, speed_target=3.2, speed_reference=2.0, bit_speed=0.0)
    assert policy.desired_reference(seen, {}, np.zeros((1, policy.memory)))[0] == 3.2


@pytest.mark.parametrize(("proportional", "integral"), [(0.138, 0.0222), (0.3, 0.1)])
def test_soft_drive_puts_the_torque_into_the_shaft_that_its_gains_say(proportional, integral):
    """K_p = eta K_T k_p / R + eta^2 C_m and K_i = eta K_T k_i / R, with the back-EMF made up for."""
    drive = SoftTorque(proportional=proportional, integral=integral).drive
    assert RIG.eta * RIG.K_T * drive.k_p / RIG.R + RIG.eta**2 * RIG.C_m == pytest.approx(proportional)
    assert RIG.eta * RIG.K_T * drive.k_i / RIG.R == pytest.approx(integral)
    assert drive.back_emf_share == 1.0


def test_soft_drive_cannot_be_softer_than_the_motor_itself():
    least = RIG.eta**2 * RIG.C_m
    assert SoftTorque(proportional=least).drive.k_p == pytest.approx(0.0)
    with pytest.raises(ValueError, match="proportional"):
        SoftTorque(proportional=0.99 * least)
    with pytest.raises(ValueError, match="integral"):
        SoftTorque(integral=0.0)


def twisted(policy, torque, **values):
    """Measurements of an upper shaft that carries a torque, its ends at rest."""
    return seen_by(policy, twist_23=-torque / RIG.k_2, speed_target=3.0, speed_reference=3.0, **values)


def test_z_torque_gives_way_to_the_torque_by_its_gain():
    """At the second sample the deviation is half the change of the torque; without lead it is taken as it is."""
    policy = ZTorque(gain=5.0, time_constant=2.0, lead=0.0, follow=1.0, lift=0.0)
    memory = np.zeros((1, policy.memory))
    assert policy.desired_reference(twisted(policy, 0.3), {}, memory)[0] == pytest.approx(3.0)
    assert policy.desired_reference(twisted(policy, 0.5), {}, memory)[0] == pytest.approx(3.0 - 5.0 * 0.1)


def test_z_torque_looks_ahead_along_the_strings_mode():
    """Half a period on, a swing of the torque is its opposite."""
    now, later = (ZTorque(lead=lead, follow=0.5, lift=0.0) for lead in (0.0, 0.5 / RIG.string_frequencies[0]))
    memories = [np.zeros((1, policy.memory)) for policy in (now, later)]
    for torque in (0.3, 0.5, 0.45, 0.2):
        wanted = [
            policy.desired_reference(twisted(policy, torque), {}, memory)[0] - 3.0
            for policy, memory in zip((now, later), memories, strict=True)
        ]
    assert wanted[0] != pytest.approx(0.0, abs=1e-3)
    assert wanted[1] == pytest.approx(-wanted[0])


def test_z_torque_lifts_by_what_the_amplitude_is_above_calm():
    policy = ZTorque(gain=0.0, time_constant=2.0, lead=0.0, follow=1.0, lift=4.0, calm=0.1)
    memory = np.zeros((1, policy.memory))
    memory[0, -1] = 0.2**2 / (1.0 - 0.1 / 5.0)  # what one more step without a torque leaves of an amplitude of 0.2 N m
    calm = 0.1 * RIG.impedance * 3.0
    assert policy.desired_reference(twisted(policy, 0.3), {}, memory)[0] == pytest.approx(3.0 + 4.0 * (0.2 - calm))
    memory[0, -1] = 0.5 * calm**2
    assert policy.desired_reference(twisted(policy, 0.3), {}, memory)[0] == pytest.approx(3.0)


def swinging(policy, steps, amplitude):
    """References that a speed pulse wants while the torque swings at the string's mode, from its peak on."""
    memory, wanted = np.zeros((1, policy.memory)), []
    frequency = RIG.string_frequencies[0]
    for step in range(steps):
        torque = 0.4 + amplitude * np.cos(2 * np.pi * frequency * 0.1 * step)
        wanted.append(policy.desired_reference(twisted(policy, torque), {}, memory)[0])
    return np.array(wanted), frequency


def test_speed_pulse_is_as_high_as_the_torque_swings_and_as_long_as_it_is_told():
    policy = SpeedPulse(strength=4.0, phase=0.25, length=0.5, pause=1.0, follow=0.3)
    wanted, frequency = swinging(policy, 200, 0.2)
    up = wanted > 3.0
    begins = np.flatnonzero(up[1:] & ~up[:-1]) + 1
    assert begins[0] * 0.1 >= 1.0 / frequency
    ends = np.flatnonzero(~up[1:] & up[:-1]) + 1
    np.testing.assert_allclose((ends[:3] - begins[:3]) * 0.1, 0.5 / frequency, atol=0.11)
    assert wanted[begins[3]] == pytest.approx(3.0 + 4.0 * 0.2, abs=0.12)
    phases = (begins[2:] * 0.1 * frequency) % 1.0
    np.testing.assert_allclose(phases, 0.25, atol=1.6 * frequency * 0.1)  # the phase is met within a step and a half
    assert np.diff(begins).min() * 0.1 >= 1.5 / frequency - 0.1


def test_speed_pulse_meets_its_phase_within_a_step_and_a_half():
    policy, due = SpeedPulse(phase=0.3, follow=0.3), []
    memory, frequency = np.zeros((1, policy.memory)), RIG.string_frequencies[0]
    for step in range(400):
        torque = 0.4 + 0.2 * np.cos(2 * np.pi * frequency * 0.1 * step)
        due.append(policy._listen(twisted(policy, torque), memory, frequency)[1][0])
    assert np.mean(due[100:]) == pytest.approx(1.5 * 0.1 * frequency, rel=0.05)


def test_speed_pulse_lets_a_swing_be_that_is_below_shaking():
    """Amplitude / Z is the bit's swing; up to 10 % of the target it counts as calm."""
    for share, pulses in ((0.09, False), (0.12, True)):
        amplitude = share * 3.0 * RIG.impedance
        assert (swinging(SpeedPulse(follow=0.3), 200, amplitude)[0][100:].max() > 3.0) == pulses


FRICTION = Friction(20.0)
TOLD = {name: np.array([getattr(FRICTION, name)]) for name in FeedForwardStart.privileged}
STEADY = FRICTION.torque(RIG, 3.2)


def test_feed_forward_start_goes_on_to_its_floor_while_calm_and_stops_when_it_shakes():
    policy = FeedForwardStart(margin=0.1, ease=0.5)
    memory = np.zeros((1, policy.memory))
    seen = seen_by(
        policy, twist_23=-STEADY / RIG.k_2, top_speed=3.2, collar_speed=3.2, speed_reference=3.2, speed_target=3.4
    )
    assert policy.desired_reference(seen, TOLD, memory)[0] == pytest.approx(3.25)  # at 0.5 rad/s^2 towards 3.4
    seen["speed_target"] = np.array([1.0])
    floor = critical_speed(RIG, FRICTION) + 0.1
    assert policy.desired_reference(seen, TOLD, memory)[0] == pytest.approx(max(3.15, floor))
    drop = 20.0 * 0.0485 * 0.194
    for share, stops in ((0.49, False), (0.52, True)):
        memory = np.zeros((1, policy.memory))
        memory[0, [2, 4]] = STEADY, (share * drop) ** 2 / np.exp(-0.1 / 2.5)
        assert (policy.desired_reference(seen, TOLD, memory)[0] == 0.0) == stops


def test_feed_forward_start_takes_a_torque_on_the_collars_for_no_shaking():
    """In calm rotation the string carries it beside the bit's torque."""
    rig = Rig(T_r2=0.15)
    policy = FeedForwardStart(rig=rig)
    calm = (STEADY + rig.T_r2) / rig.k_2
    seen = seen_by(policy, twist_23=-calm, top_speed=3.2, collar_speed=3.2, speed_reference=3.2, speed_target=3.2)
    memory = np.zeros((1, policy.memory))
    for _ in range(100):
        assert policy.desired_reference(seen, TOLD, memory)[0] > 3.0
    assert memory[0, 4] == pytest.approx(0.0, abs=1e-12)


def test_feed_forward_start_measures_unrest_by_the_mean_square_of_swings_to_either_side():
    """Over 2.5 s: 1 / e of the square is still to come by then."""
    policy = FeedForwardStart()
    memory = np.zeros((1, policy.memory))
    for step in range(25):
        torque = STEADY + (-1) ** step * 0.05
        seen = twisted(policy, torque, top_speed=3.2, collar_speed=3.2) | {"speed_reference": np.array([3.2])}
        policy.desired_reference(seen, TOLD, memory)
    assert memory[0, 4] == pytest.approx(0.05**2 * (1.0 - 1.0 / np.e))


def test_feed_forward_start_smooths_torque_and_speed_over_half_a_second():
    """0.5 s after a step, 1 / e of it is still to come; the first value is taken as it is."""
    policy = FeedForwardStart()
    memory = np.zeros((1, policy.memory))
    first, then = (
        twisted(policy, torque, top_speed=speed, collar_speed=speed) for torque, speed in ((0.3, 2.0), (0.5, 3.0))
    )
    policy.desired_reference(first, TOLD, memory)
    assert memory[0, 2:4] == pytest.approx([0.3, 2.0])
    for _ in range(5):
        policy.desired_reference(then, TOLD, memory)
    assert memory[0, 2:4] == pytest.approx([0.5 - 0.2 / np.e, 3.0 - 1.0 / np.e])


def test_feed_forward_start_waits_for_the_string_to_come_to_rest():
    """3 s from when drive and reference stand still; moving on the way begins the wait anew."""
    policy = FeedForwardStart()
    memory = np.zeros((1, policy.memory))
    memory[0, 0], memory[0, 2] = 1.0, 0.3  # it stops
    still = seen_by(policy, twist_23=-0.3 / RIG.k_2, speed_target=3.2)
    moving = {**still, "speed_reference": np.array([0.2])}
    for seen, steps, phase in ((still, 20, 1.0), (moving, 1, 1.0), (still, 29, 1.0), (still, 1, 2.0)):
        for _ in range(steps):
            policy.desired_reference(seen, TOLD, memory)
        assert memory[0, 0] == phase
    assert memory[0, 5] == pytest.approx(0.3, abs=1e-3)  # the torque that the plan starts from


def test_estimated_friction_is_the_chapters_share_of_what_has_been_seen():
    policy = JumpEaseEstimated(spread=0.1)
    memory = np.zeros((1, policy.memory))
    memory[0, 2] = 20.0 * RIG.r_1 * 0.5  # the torque at break-loose, and no calm rotation yet
    likely, slow, fast = policy.estimates(memory)
    assert [friction.v_b[0] for friction in (likely, slow, fast)] == pytest.approx([1.0, 0.9, 1.1])
    assert likely.normal_force[0] == pytest.approx(20.0)
    assert likely.mu_k[0] == pytest.approx(0.9 * 0.306)  # lower by the spread until it is seen
    memory[0, 3:] = FRICTION.torque(RIG, 3.0), 3.0  # calm rotation at 3 rad/s
    likely, slow, fast = policy.estimates(memory)
    assert likely.mu_k[0] == pytest.approx(0.306)
    for friction in (likely, slow, fast):
        assert friction.torque(RIG, 3.0)[0] == pytest.approx(FRICTION.torque(RIG, 3.0))


def test_until_the_bit_has_stuck_the_torque_of_a_turning_bit_is_taken_once_for_its_load():
    policy = JumpEaseEstimated()
    memory = np.zeros((1, policy.memory))
    for torque, taken in ((-0.2, 0.0), (0.3, 0.3), (0.5, 0.3), (0.1, 0.3)):
        values = {"bit_speed": 2.0, "collar_speed": 2.0, "bit_speed_deviation": 1.0, "bit_speed_mean": 2.0}
        policy._watch(seen_by(policy, twist_12=-torque / RIG.k_1, **values), memory)
        assert memory[0, 2] == pytest.approx(taken)


def test_estimate_takes_the_largest_torque_while_stuck_and_half_a_step_of_winding():
    policy = JumpEaseEstimated()
    memory = np.zeros((1, policy.memory))
    stiffness = RIG.k_1 * RIG.k_2 / (RIG.k_1 + RIG.k_2)
    for torque, top in ((0.3, 2.0), (0.45, 2.0), (0.4, 2.0)):
        seen = seen_by(policy, twist_12=-torque / RIG.k_1, top_speed=top, bit_speed_deviation=1.0, bit_speed_mean=2.0)
        policy._watch(seen, memory)
    assert memory[0, 2] == pytest.approx(0.45 + 0.5 * stiffness * 2.0 * 0.1)
    seen = seen_by(
        policy, twist_12=-0.9 / RIG.k_1, bit_speed=2.0, collar_speed=2.0, bit_speed_deviation=1.0, bit_speed_mean=2
    )
    policy._watch(seen, memory)
    assert memory[0, 2] < 0.5  # a bit that turns does not say what breaks it loose
    assert memory[0, 4] == 0.0
    seen["bit_speed_deviation"] = np.array([0.09])  # below 5 % of the mean: calm
    policy._watch(seen, memory)
    assert memory[0, 3:].tolist() == pytest.approx([0.9, 2.0])


def test_longest_delay_is_reckoned_on_with_the_references_since():
    """In steady rotation at a reference that has not moved for ten steps, it does not matter how late that is seen."""
    policy, wanted = MPPI(samples=0, threads=1), []
    x = steady_state(RIG, FRICTION, 4.0)
    seen = seen_by(policy, **dict(zip(STATE_NAMES, x, strict=True)), speed_reference=4.0, speed_target=4.0)
    for delay in (0, 10):
        policy.tell({**TOLD, "delay": delay})
        memory = np.zeros((1, policy.memory))
        memory[0, KNOTS], memory[0, KNOTS + 1 :] = 21.0, 4.0
        wanted.append(policy.desired_reference(seen, TOLD, memory)[0])
        assert memory[0, KNOTS] == 22.0
    assert wanted == pytest.approx([4.0, 4.0], abs=1e-6)


def test_who_is_told_of_no_delay_reckons_with_none():
    """Off steady rotation a step of delay would show: the state seen is not that of now."""
    x = steady_state(RIG, FRICTION, 4.0) + 0.3 * np.eye(7)[2]
    policy, wanted = MPPI(samples=0, threads=1), []
    seen = seen_by(policy, **dict(zip(STATE_NAMES, x, strict=True)), speed_reference=4.0, speed_target=4.0)
    for delay in ({}, {"delay": 0}, {"delay": 1}):
        policy.tell({**TOLD, **delay})
        memory = np.zeros((1, policy.memory))
        memory[0, KNOTS], memory[0, KNOTS + 1 :] = 21.0, 4.0
        wanted.append(policy.desired_reference(seen, TOLD, memory)[0])
    assert wanted[0] == wanted[1]
    assert wanted[2] != pytest.approx(wanted[1], abs=1e-3)
    row = SetPointFeedback([RIG], effort=30.0).at(FRICTION, np.array([4.0]))
    assert wanted[0] == pytest.approx(4.0 + wanted_change(row, x[None], np.array([4.0]))[0])


def test_plans_with_a_name_start_and_end_where_they_say():
    """Knots lie 0.2 s apart."""
    times = 0.2 * np.arange(KNOTS)
    plans = _named(np.array([[[0.4]]]), np.array([2.0]), 0.1)[0]
    assert plans.shape == (2 + 1 + 4 + 16, KNOTS)
    np.testing.assert_array_equal(plans[0], 0.0)
    np.testing.assert_allclose(np.exp(plans[1]), 0.8)
    np.testing.assert_array_equal(plans[2], 0.4)
    for plan, seconds in zip(plans[3:7], (1.0, 2.0, 4.0, 8.0), strict=True):
        np.testing.assert_allclose(plan, 0.4 * np.maximum(1.0 - times / seconds, 0.0))
    np.testing.assert_allclose(np.exp(plans[7::4, 0]) * 2.0, [4.0, 6.0, 8.0, 10.0])
    for jump, (dwell, down) in zip(plans[7:11], ((1.0, 3.0), (1.0, 6.0), (3.0, 3.0), (3.0, 6.0)), strict=True):
        np.testing.assert_allclose(jump, np.log(2.0) * np.clip((dwell + down - times) / down, 0.0, 1.0))
    assert _named(np.array([[[0.0]]]), np.array([5.0]), 0.1)[0][7].max() == 0.0  # no jump to below the target


def test_perturbations_are_correlated_from_knot_to_knot_and_of_their_deviations_in_turn():
    noise = _coloured(np.random.default_rng(0), 300, (0.1, 0.4))
    for first, deviation in ((0, 0.1), (1, 0.4)):
        part = noise[:, first::2]
        assert part.std() == pytest.approx(deviation, rel=0.02)
        assert part[..., -1].std() == pytest.approx(deviation, rel=0.05)
        assert np.corrcoef(part[..., 4].ravel(), part[..., 5].ravel())[0, 1] == pytest.approx(0.7, abs=0.03)
        assert np.corrcoef(part[..., 4].ravel(), part[..., 6].ravel())[0, 1] == pytest.approx(0.49, abs=0.03)
