"""Policies: the one contract that every controller and agent meets, how one is found by name, and how to check it.

What is known of a policy by its name, and what it says of itself:

>>> from drillrig_env import Task
>>> from drillrig_env.policy import context_of, drive_of, find_policy, is_exact, make_policy, privileged_of
>>> find_policy("lqg").name
'lqg'
>>> privileged_of(make_policy("jump_ease"))
('normal_force', 'mu_s', 'mu_k', 'v_b')
>>> drive_of(make_policy("lqg")) is None, drive_of(make_policy("soft_torque")) is None
(True, False)
>>> is_exact(make_policy("lqg"))
False
>>> sorted(context_of(Task()))
['control_period', 'fleet', 'largest_reference', 'rig', 'sensors', 'slew_limit']
"""

from drillrig_env.policy.checks import check_policy
from drillrig_env.policy.contract import Memory, Policy, channels_of, drive_of, is_exact, privileged_of
from drillrig_env.policy.finding import (
    GROUP,
    PolicySource,
    UnknownPolicyError,
    context_of,
    find_policy,
    load,
    make_policy,
    policy_names,
)
from drillrig_env.policy.home import AtHome

__all__ = [
    "GROUP",
    "AtHome",
    "Memory",
    "Policy",
    "PolicySource",
    "UnknownPolicyError",
    "channels_of",
    "check_policy",
    "context_of",
    "drive_of",
    "find_policy",
    "is_exact",
    "load",
    "make_policy",
    "policy_names",
    "privileged_of",
]
