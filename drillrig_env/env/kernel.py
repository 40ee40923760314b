"""One control step and one start of a rig, in compiled code: physics, statistics, reward, observation.

A batch is an array of records (`drillrig_env.env.episode`), one a rig, and every kernel treats its rigs one by one.
This is all that there is to a step; the single, the vector and the SB3 environment call it alike.
"""

from __future__ import annotations

from math import inf, isfinite, pi, sqrt

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray, Record, Records
from drillrig_env.env.randomness import gaussian
from drillrig_env.env.reward_kernel import reward_terms, update_statistics
from drillrig_env.env.scenario import STEADY, STICK_SLIP
from drillrig_env.env.sensors import CHANNELS, LIMIT
from drillrig_env.env.varying import vary
from drillrig_env.friction.law import press
from drillrig_env.jit.ahead import fetch
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.jit.pointer import call_on
from drillrig_env.stepper.ladder import SAMPLES, UNITS, from_equilibrium, to_states
from drillrig_env.stepper.propagator import advance
from drillrig_env.stepper.workspace import WORKSPACE

_CHANNELS = len(CHANNELS)
_AHEAD = 2  # episodes, of whose memory the processor is told before
Past = npt.NDArray[np.float32]

SCRATCH = np.dtype([("work", WORKSPACE), ("values", "f8", _CHANNELS)], align=True)


def scratch() -> np.ndarray:
    """What a kernel needs of memory besides: a record of SCRATCH for each thread that runs one."""
    return np.zeros(1, dtype=SCRATCH)


@compiled
def step_episodes(
    order: npt.NDArray[np.intp],
    episodes: Records,
    actions: npt.NDArray[np.float32],
    settings: Records,
    plants: Records,
    ladders: Records,
    course: FloatArray,
    layout: Records,
    past: Past,
    observations: npt.NDArray[np.float32],
    scratch: Records,
) -> int:
    """Step every rig whose episode is not over by one control step, in place; how many are no longer finite.

    `order` has the places of the episodes that are stepped, in turn: one after the other, those of a rig find its
    tables near the processor. `episodes` is an array of EPISODE, `actions` has shape (n, 1), `settings` is a SETTINGS
    record array of length 1; `plants` and `ladders` are those of a `RigBank`, one a rig first; `course` has a row for
    each control step, as `Course.table` gives it, and none where nothing is given; `layout` is the sensors' and
    `observations` of shape (n, channels) is filled for these episodes.
    `past` of shape (n, longest delay + 1, channels) keeps the measurements that are still to be seen; without
    delay it has no entries.
    """
    s, work, values, lost = settings[0], scratch[0].work, scratch[0].values, 0
    for i in range(order.shape[0]):
        n = order[i]
        episode = episodes[n]
        soon = order[min(i + _AHEAD, order.shape[0] - 1)]
        fetch(episodes, soon)
        fetch(actions, soon)
        fetch(past, soon)
        fetch(observations, soon)
        if episode.step < s.steps:
            k = episode.rig
            _step(episode, actions[n, 0], s, plants[k], ladders, course, work)
            lost += not _is_finite(episode.state)
            if s.own_terms > 0:
                lost += not _add_own_terms(episode, actions[n, 0], s)
        measure(episode, layout, values, observations[n])
        if past.shape[1] > 0:
            _delay(episode, layout, past[n], observations[n])
    return lost


@compiled
def observe_episodes(
    episodes: Records, layout: Records, past: Past, observations: npt.NDArray[np.float32], scratch: Records
) -> None:
    """Fill the first observations of episodes, shape (n, channels), and `past` with nothing but these."""
    values = scratch[0].values
    for n in range(episodes.shape[0]):
        measure(episodes[n], layout, values, observations[n])
        for slot in range(past.shape[1]):
            for i in range(past.shape[2]):  # entry by entry: an assignment of slices takes long to compile
                past[n, slot, i] = observations[n, i]


@inlined
def _step(
    episode: Record,
    action: float,
    s: Record,
    plant: Record,
    ladders: Records,
    course: FloatArray,
    work: Record,
) -> None:
    action = min(max(float(action), -1.0), 1.0)
    episode.speed_reference = min(max(episode.speed_reference + action * s.slew, 0.0), s.largest_reference)
    vary(episode, s, course)
    _hold(episode, s, plant, ladders, work)
    variance, tracking, effort = reward_terms(
        episode.mean,
        episode.variance,
        episode.speed_target,
        action,
        s.variance_weight,
        s.tracking_weight,
        s.action_weight,
        s.deviation,
        s.absolute,
        s.phases,
        s.tracking_swing,
    )
    episode.terms[0], episode.terms[1], episode.terms[2] = variance, tracking, effort
    episode.reward = variance + tracking + effort
    if episode.step == s.window_start:
        episode.window_lowest, episode.window_highest, episode.window_sum = episode.lowest, episode.highest, 0.0
    episode.window_lowest = min(episode.window_lowest, episode.lowest)
    episode.window_highest = max(episode.window_highest, episode.highest)
    episode.window_sum += episode.average
    episode.step += 1


@compiled
def _add_own_terms(episode: Record, action: float, s: Record) -> bool:
    """Add the terms of the user's own to the reward of a step that is done; whether it is finite."""
    call_on(s.address, episode, min(max(float(action), -1.0), 1.0))
    for i in range(s.own_terms):
        episode.reward += episode.own_terms[i]
    return isfinite(episode.reward)


@inlined
def _hold(episode: Record, s: Record, plant: Record, ladders: Records, work: Record) -> None:
    """One control period of physics at the rig's speed reference, and what its samples tell."""
    x, y, contact, ladder = episode.state, work.y, work.contact, ladders[episode.rig]
    press(contact, episode.normal_force, episode.mu_s, episode.mu_k, episode.v_b, plant.r_1, plant.omega_s, s.law)
    contact.speed_reference = episode.speed_reference
    top_speed, error_integral = x[4], x[6]
    from_equilibrium(x, contact, ladder, y)
    contact.tilt = s.tilt if episode.turns > 0 else 0.0
    if s.tilt > 0.0:
        twists = y[0] + y[1] - y[6]
        contact.turns, contact.period = episode.turns, s.control_period
        contact.angle = episode.turns * (x[7] - twists) + s.tilt_phase
    advance(y, contact, ladders, episode.rig, work, True, UNITS)
    to_states(y, contact, ladder, x)
    if s.tilt > 0.0:
        x[7] = (x[7] + episode.speed_reference * s.control_period + (y[0] + y[1] - y[6] - twists)) % (2.0 * pi)
    lowest = highest = work.speed_samples[0]
    highest_torque = work.torque_samples[0]
    mean, variance, total, torque, stuck = episode.mean, episode.variance, 0.0, 0.0, 0
    for k in range(SAMPLES):
        speed = work.speed_samples[k]
        lowest, highest = min(lowest, speed), max(highest, speed)
        highest_torque = max(highest_torque, work.torque_samples[k])
        total += speed
        torque += work.torque_samples[k]
        stuck += speed < s.stuck_speed
        mean, variance = update_statistics(mean, variance, speed, s.gain)
    episode.mean, episode.variance = mean, variance
    episode.lowest, episode.highest, episode.average = lowest, highest, total / SAMPLES
    episode.stuck = stuck / SAMPLES
    episode.torque_into_string, episode.highest_torque = work.torque_samples[SAMPLES - 1], highest_torque
    mean_top_speed = episode.speed_reference - (x[6] - error_integral) / s.control_period
    if plant.voltage_room < inf:  # the integrator may follow the limit
        mean_top_speed = 0.5 * (top_speed + x[4])
    estimate = plant.torque_gain * (torque / SAMPLES) + plant.torque_per_speed * mean_top_speed
    episode.string_torque = estimate + plant.torque_per_change * (x[4] - top_speed) + plant.torque_offset
    deviation = episode.string_torque - episode.torque_mean
    episode.torque_mean += s.torque_mean_gain * deviation
    episode.torque_variance += s.torque_variance_gain * (deviation * deviation - episode.torque_variance)
    asked = s.k_p * (episode.speed_reference - x[4]) + s.k_i * x[6] + plant.back_emf_compensation * x[4]
    back_emf, room = plant.back_emf * x[4], plant.voltage_room
    episode.voltage = min(max(asked, back_emf - room), back_emf + room) + plant.voltage_offset


@inlined
def _is_finite(state: FloatArray) -> bool:
    finite = True
    for i in range(7):
        finite &= isfinite(state[i])
    return finite


@compiled
def measure(episode: Record, layout: Records, values: FloatArray, observation: npt.NDArray[np.float32]) -> None:
    """Measure the channels of `layout` and scale them into one observation; `values` follows the order of CHANNELS."""
    for i in range(7):
        values[i] = episode.state[i]
    values[7], values[8] = episode.speed_reference, episode.speed_target
    values[9], values[10] = episode.mean, sqrt(episode.variance)
    values[11], values[12] = episode.voltage, episode.string_torque
    values[13], values[14] = episode.torque_mean, sqrt(episode.torque_variance)
    for i in range(layout.shape[0]):
        channel = layout[i]
        value = values[channel.source]
        if channel.noise > 0.0:
            episode.noise, deviation = gaussian(episode.noise)
            value += channel.noise * deviation
        scaled = (value - channel.offset - channel.from_target * episode.speed_target) / channel.scale
        observation[i] = min(max(scaled, -LIMIT), LIMIT)


@inlined
def _delay(episode: Record, layout: Records, past: Past, observation: npt.NDArray[np.float32]) -> None:
    """Keep a new observation in the ring `past`, and put older measurements in its place."""
    slots = past.shape[0]
    now, seen = episode.step % slots, (episode.step - episode.delay) % slots
    for i in range(layout.shape[0]):
        past[now, i] = observation[i]
        if layout[i].late:
            observation[i] = past[seen, i]


_DEVIATION_OF_CALM = 0.02
"""A running deviation below this share of the speed reference means that the oscillation has died."""


@compiled
def settle_episodes(
    episodes: Records,
    phases: FloatArray,
    settings: Records,
    plants: Records,
    ladders: Records,
    scratch: Records,
) -> None:
    """Bring wound-up rigs onto their stick-slip cycle, each to its phase (0 to 1); all in place.

    A rig is run for `settling` control steps or more at its speed reference. Where it then still sticks and slips, it
    is run on by `phase` times the last period, to the nearest control step below. Where its oscillation dies instead,
    there is no stick-slip with these parameters: `start` becomes STEADY. A rig whose state is no longer finite is left
    there.
    """
    s, work = settings[0], scratch[0].work
    for n in range(episodes.shape[0]):
        episode, k = episodes[n], episodes[n].rig
        episode.start = STEADY
        was_stuck, last_release, period, end = True, 0, 0, s.longest_settling
        step = 0
        while step < end:
            _hold(episode, s, plants[k], ladders, work)
            if not _is_finite(episode.state):
                end = step
            if episode.start == STEADY:  # not yet found to cycle
                is_stuck = episode.stuck > 0.0
                if was_stuck and not is_stuck:
                    period, last_release = step - last_release, step
                was_stuck = is_stuck
                if step >= s.settling:
                    if period > 0 and step - last_release <= period and step > 2 * period:
                        episode.start, end = STICK_SLIP, step + 1 + int(phases[n] * period)
                    elif sqrt(episode.variance) < _DEVIATION_OF_CALM * episode.speed_reference:
                        end = step
            step += 1
