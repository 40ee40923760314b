"""Who competes: policies by name, folder, or file and class, each seen through an environment's own sensors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from drillrig_env.env.kernel import SLEW_LIMIT
from drillrig_env.env.registration import ENVIRONMENTS
from drillrig_env.env.sensors import Sensors
from drillrig_env.evaluation.contest import Contestant, Failure
from drillrig_env.evaluation.suites import Suite
from drillrig_env.policy import Policy, PolicySource, channels_of, drive_of, find_policy, policy_names, privileged_of


def find_contestants(
    names: Sequence[str], env_id: str, slow: bool = False, say: Callable[[str], object] = print
) -> tuple[list[Contestant], list[Failure]]:
    """The contestants of these names, or all that suit the environment, and who cannot compete.

    Without names these are all installed policies and the trained agents of the clone. One that does not
    suit, or that is slow while `slow` is false, is then left out; `say` is called with a line that says why.
    """
    contestants, failures = [], []
    for name in names or policy_names():
        try:
            source = find_policy(name)
            if not (names or slow) and source.slow:
                say(f"{name} is left out: it is slow; --slow lets it in")
                continue
            contestants.append(contestant_of(source, env_id, _label(name, names)))
        except Exception as error:  # a stranger's file may raise anything
            if names:
                failures.append(Failure.of(name, "", error))
            else:
                say(f"{name} is left out: {error}")
    return contestants, failures


def contestant_of(source: PolicySource, env_id: str, label: str | None = None) -> Contestant:
    """A policy, or all its training seeds, as it competes in an environment; `label` is its name in the tables.

    Made once here, so that one that cannot be made is known early. `ValueError` where the environment's
    sensors do not show what the policy must see; beyond it, whatever the policy itself raises.
    """
    label = label or source.name
    shown = Sensors.named(ENVIRONMENTS[env_id]["sensors"])
    made = [source.make(seed, sensors=shown.name, slew_limit=SLEW_LIMIT) for seed in source.makers]
    sees = channels_of(made[0])
    if missing := [channel for channel in sees or () if channel not in shown.names]:
        raise ValueError(f"{label} sees {', '.join(missing)}, which the sensors of {env_id} do not show")
    env: dict[str, Any] = dict(ENVIRONMENTS[env_id])
    if sees is not None and sees != shown.names:
        env |= {"sensors": sees, "noise": shown.noise, "delay": shown.delay}
    members = {seed: partial(_for_suite, source, seed, shown.name) for seed in source.makers}
    about = dict(source.about)
    if about.get("kind") != "run":
        about["parameters"] = _parameters(made[0])
    return Contestant(label, members, env, privileged_of(made[0]), drive_of(made[0]), about)


def _for_suite(source: PolicySource, seed: str, sensors: str, suite: Suite) -> Policy:
    return source.make(seed, sensors=sensors, slew_limit=suite.slew_limit)


def _parameters(policy: Policy) -> Mapping[str, int | float | str]:
    """The plain values that tell a policy from another of its class; its action's meaning is the suite's."""
    return {
        key: value
        for key, value in vars(policy).items()
        if isinstance(value, int | float | str) and not key.startswith("_") and key != "slew_limit"
    }


def _label(name: str, others: Sequence[str]) -> str:
    """The name in the tables: the last part of a path or the class of a file, or all of it where two end alike."""

    def last(full: str) -> str:
        return Path(full).name.rpartition(":")[2]

    return last(name) if [last(other) for other in others].count(last(name)) <= 1 else name
