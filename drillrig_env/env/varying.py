"""What changes within an episode from control step to control step, in compiled code: force, friction and target.

Within a control step they are constant, but for a normal force that varies as the disc turns.
"""

from __future__ import annotations

from math import exp, isnan

from drillrig_env.arrays import FloatArray, Record
from drillrig_env.env.randomness import fast_gaussian
from drillrig_env.env.scenario import MOST_LOAD_STEPS
from drillrig_env.jit.compiled import inlined

_SAME_STEP = 1e-8  # share of a control step by which a step may be late for its time, in rounding


@inlined
def vary(episode: Record, s: Record, course: FloatArray) -> None:
    """Bring a rig's force, friction and target to what they are in the coming control step.

    `episode` is a record of EPISODE, `s` one of SETTINGS; `course` is that of `step_episodes`.
    """
    now = (episode.step + _SAME_STEP) * s.control_period
    while episode.next_load < MOST_LOAD_STEPS and episode.load_times[episode.next_load] <= now:
        episode.normal_force = episode.load_forces[episode.next_load]
        episode.next_load += 1
    if episode.target_time <= now:
        episode.speed_target = episode.next_target
        episode.target_time = float("inf")
    if course.shape[0] > 0:
        _follow(episode, course[episode.step])
    if s.added > 0.0:
        _wander(episode, s)


@inlined
def _follow(episode: Record, given: FloatArray) -> None:
    """Take what a course gives for a control step."""
    if not isnan(given[0]):
        episode.normal_force = given[0]
    if not isnan(given[1]):
        episode.mu_s = episode.coefficients[0] = given[1]
        episode.mu_k = episode.coefficients[1] = given[2]
    if not isnan(given[3]):
        episode.v_b = episode.coefficients[2] = given[3]
    if not isnan(given[4]):
        episode.speed_target = given[4]


@inlined
def _wander(episode: Record, s: Record) -> None:
    """Take the logarithms of the coefficients on by a control step, Ornstein-Uhlenbeck processes."""
    for i in range(3):
        episode.wandering, deviation = fast_gaussian(episode.wandering)
        episode.logarithms[i] = s.kept * episode.logarithms[i] + s.added * deviation
    mu_s, mu_k = episode.coefficients[0], episode.coefficients[1]
    episode.mu_k = mu_k * exp(episode.logarithms[0])
    episode.mu_s = episode.mu_k + (mu_s - mu_k) * exp(episode.logarithms[1])
    episode.v_b = episode.coefficients[2] * exp(episode.logarithms[2])
