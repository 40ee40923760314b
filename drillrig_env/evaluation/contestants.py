"""Who competes: policies by name, folder, or file and class, each seen through an environment's own sensors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from drillrig_env.evaluation.conditions import Conditions, conditions_for, showing
from drillrig_env.evaluation.contest import Contestant, Failure
from drillrig_env.evaluation.suites import Suite
from drillrig_env.friction import Friction
from drillrig_env.policy import (
    Policy,
    PolicySource,
    UnknownPolicyError,
    channels_of,
    drive_of,
    find_policy,
    is_exact,
    policy_names,
    privileged_of,
)
from drillrig_env.rig import Rig, RigLike
from drillrig_env.scales import SLEW_LIMIT


class UnseenError(ValueError):
    """A policy must see what the sensors of an environment do not show."""


def find_contestants(
    names: Sequence[str],
    env_id: str | None = None,
    slow: bool = False,
    say: Callable[[str], object] = print,
    rig: RigLike = None,
    largest_reference: float | None = None,
    friction: Friction | None = None,
) -> tuple[list[Contestant], list[Failure], Conditions]:
    """The contestants of these names, or all that suit the environment; who cannot compete; and the conditions.

    The conditions are those of `env_id`, or of the trainings of named agents: see `conditions_for`; `rig` is the rig of
    the suites, as `Rig.of` takes it, and `largest_reference` (rad/s) the upper end of its speed reference, None its
    own; `friction` is what policies are designed for, None the chapter's. Without names the contestants are all
    installed policies and the trained agents of the clone. One that does not suit, that needs what is not installed, or
    that is slow while `slow` is false, is then left out. `say` is called with a line that says why, and what differs
    from an agent's training. `UnknownPolicyError` for a name that is nothing.
    """
    sources, failures = _find_sources(names, slow, say)
    trainings = {
        label: next(iter(source.about["configs"].values()))
        for label, source in sources.items()
        if names and source.about.get("kind") == "run"
    }
    conditions = conditions_for(trainings, env_id, say)
    conditions = replace(conditions, rig=Rig.of(rig), largest_reference=largest_reference, friction=friction)
    contestants = []
    for label, source in sources.items():
        try:
            contestants.append(contestant_of(source, conditions, label))
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # a stranger's policy may raise anything
            if names:
                plain = isinstance(error, UnseenError)
                failures.append(Failure(label, "", str(error)) if plain else Failure.of(label, "", error))
            else:
                say(f"{label} is left out: {error}")
    return contestants, failures, conditions


def _find_sources(
    names: Sequence[str], slow: bool, say: Callable[[str], object]
) -> tuple[dict[str, PolicySource], list[Failure]]:
    """Where the policies of these names, or all, come from, by their names in the tables; and what cannot be read."""
    sources, failures = {}, []
    for name in names or policy_names():
        try:
            source = find_policy(name)
        except (UnknownPolicyError, KeyboardInterrupt):
            raise
        except BaseException as error:  # a stranger's file may raise anything
            if isinstance(error, ImportError) and not names:
                say(f"{name} is left out: {error}")
            else:
                failures.append(Failure.of(name, "", error))
            continue
        if source.slow and not (names or slow):
            say(f"{name} is left out: it is slow; --slow lets it in")
        else:
            sources[_label(name, names)] = source
    return sources, failures


def contestant_of(source: PolicySource, conditions: str | Conditions, label: str | None = None) -> Contestant:
    """A policy, or all its training seeds, as it competes under some conditions; `label` is its name in the tables.

    `conditions` may be an environment's id, for its standard ones. The policy is made once here, so that one that
    cannot be made is known early. `UnseenError`, a `ValueError`, where the environment's sensors do not show what the
    policy must see, unless it is exact; beyond it, whatever the policy itself raises.
    """
    label = label or source.name
    held = Conditions.named(conditions)
    shown = held.sensors
    context: dict[str, Any] = {"sensors": shown.name, "rig": held.rig, "largest_reference": held.largest_reference}
    if held.friction is not None:
        context["friction"] = held.friction
    made = [source.make(seed, **context, slew_limit=SLEW_LIMIT * held.scales.rate) for seed in source.makers]
    sees, exact = channels_of(made[0]), is_exact(made[0])
    missing = [channel for channel in sees or () if channel not in shown.names]
    if missing and not exact:
        other = next(iter(showing(sees or ())), None)
        hint = f"; those of {other} do" if other else ""
        raise UnseenError(f"{label} sees {', '.join(missing)}, which the sensors of {held.env_id} do not show{hint}")
    env = held.arguments
    if sees is not None and sees != shown.names:
        env["sensors"] = sees
    members = {seed: partial(_for_suite, source, seed, context) for seed in source.makers}
    about = dict(source.about)
    if about.get("kind") != "run":
        about["parameters"] = _parameters(made[0])
    return Contestant(label, members, env, privileged_of(made[0]), drive_of(made[0]), about, exact)


def _for_suite(source: PolicySource, seed: str, context: Mapping[str, Any], suite: Suite) -> Policy:
    return source.make(seed, **context, slew_limit=suite.slew_limit, fleet=suite.scenario.rigs)


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
