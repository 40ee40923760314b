"""The record of a rig's episode, all that the kernels know of it."""

from __future__ import annotations

import numpy as np

from drillrig_env.env.reward_terms import MOST_TERMS
from drillrig_env.env.scenario import MOST_LOAD_STEPS
from drillrig_env.stepper.ladder import STATE

EPISODE = np.dtype(
    [
        ("state", "f8", STATE),  # the 7 states, and theta_1 (rad) where N_1 varies with it
        ("speed_reference", "f8"),
        ("speed_target", "f8"),
        ("normal_force", "f8"),
        ("mu_s", "f8"),
        ("mu_k", "f8"),
        ("v_b", "f8"),
        ("torque_into_string", "f8"),  # at the end of the last control step, N m
        ("reward", "f8"),
        ("terms", "f8", 3),  # the single environment reads all up to here as one array
        ("step", "i8"),  # control steps done in this episode
        ("delay", "i8"),  # control steps by which measurements come late
        ("mean", "f8"),  # running mean and variance of the bit speed
        ("variance", "f8"),
        ("load_times", "f8", MOST_LOAD_STEPS),  # s; infinite where there is none
        ("load_forces", "f8", MOST_LOAD_STEPS),  # N
        ("next_load", "i8"),
        ("lowest", "f8"),  # of the bit speed within the last control step
        ("highest", "f8"),
        ("average", "f8"),
        ("stuck", "f8"),  # share of the last control step
        ("highest_torque", "f8"),  # within it
        ("window_lowest", "f8"),  # of the bit speed within the episode's last seconds
        ("window_highest", "f8"),
        ("window_sum", "f8"),  # of `average`
        ("start", "i8"),  # index into STARTS, as it came out
        ("voltage", "f8"),  # of the armature at the end of the last control step, V
        ("string_torque", "f8"),  # into the string, mean over the last control step, N m
        ("torque_mean", "f8"),  # its running mean, and its running variance about that
        ("torque_variance", "f8"),
        ("noise", "u8"),  # state of the generator of the measurement noise
        ("rig", "i8"),  # index into the bank of rigs
        ("own_terms", "f8", MOST_TERMS),  # of the reward, the user's own
        ("target_time", "f8"),  # when the target steps, s; infinite where it does not
        ("next_target", "f8"),  # rad/s
        ("coefficients", "f8", 3),  # mu_s, mu_k and v_b, about which friction wanders
        ("logarithms", "f8", 3),  # of mu_k, mu_s - mu_k and v_b, by which it has wandered
        ("wandering", "u8"),  # state of the generator of that
        ("turns", "f8"),  # how often N_1 varies as disc 1 turns once
    ],
    align=True,
)
