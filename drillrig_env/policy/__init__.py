"""Policies: the one contract that every controller and agent meets, how one is found by name, and how to check it."""

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
