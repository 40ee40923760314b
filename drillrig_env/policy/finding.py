"""Policies by name: installed ones by entry point, one of yours by FILE.py:CLASS, a trained agent by its folder.

A package offers policies under the entry points `drillrig.policies`, each a class or function that makes one:

    [project.entry-points."drillrig.policies"]
    my_law = "my_package:MyLaw"

Trained agents are found where the project's clone is at hand, as after `pip install -e '.[agents]'` in it.
"""

from __future__ import annotations

import hashlib
import importlib
import inspect
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

from drillrig_env.modules import load_module
from drillrig_env.parameters import closest
from drillrig_env.policy.contract import Policy
from drillrig_env.policy.home import AtHome, rig_environment

GROUP = "drillrig.policies"
"""The group of entry points."""

_CLONE = Path(__file__).parents[2]
_AGENTS = _CLONE / "agents" / "policy" / "finding.py"
"""How the clone finds trained agents: a module with `agent_names()` and `find_agent(name)`."""

_FROM_CLONE = "where the project is installed from its clone and stays there: pip install -e '.[agents]'"


class UnknownPolicyError(ValueError):
    """There is no policy of a name: no installed one, no training run's folder, no such file or class in it."""


@dataclass(frozen=True)
class PolicySource:
    """A policy that was found, or several training seeds of one, and how to make them.

    `makers` are classes or functions that make the policy, by training seed; "" is the seed of what is not
    trained. `about` tells this policy from a changed one of the same name.
    """

    name: str
    makers: Mapping[str, Callable[..., Policy]]
    about: Mapping[str, Any] = field(default_factory=dict)

    @property
    def slow(self) -> bool:
        """Whether an episode takes minutes rather than seconds."""
        return any(getattr(maker, "slow", False) is True for maker in self.makers.values())

    def make(self, seed: str | None = None, **context: Any) -> Policy:
        """The policy of a training seed (default: the first), made for the `context` of a task; see `context_of`.

        The maker gets those that it names. `TypeError` where what it makes has no `predict`.
        """
        maker = self.makers[next(iter(self.makers)) if seed is None else seed]
        known = inspect.signature(maker).parameters
        everything = any(parameter.kind is parameter.VAR_KEYWORD for parameter in known.values())
        made = maker(**{name: value for name, value in context.items() if everything or name in known})
        if not isinstance(made, Policy):
            raise TypeError(f"{self.name} makes a {type(made).__name__}, which has no predict(observation, ...)")
        if isinstance(made, AtHome):
            made.known_as = self.name
        return made


def installed_names() -> list[str]:
    """The names of all policies that are installed."""
    return list(_installed())


def policy_names() -> list[str]:
    """The names of all policies that are installed, and of the trained agents where the clone is at hand.

    >>> from drillrig_env.policy import policy_names
    >>> "lqg" in policy_names()
    True
    """
    return [*_installed(), *(_agents().agent_names() if _AGENTS.is_file() else ())]


def find_policy(policy: Any) -> PolicySource:
    """Where a policy comes from: a name, FILE.py:CLASS, a training run's folder, a class, or a policy itself.

    `UnknownPolicyError`, a `ValueError`, for a name that is nothing of all that, with the closest one; beyond it
    whatever a file raises when it is imported.
    """
    if not isinstance(policy, str | Path):
        makes = inspect.isclass(policy) or (callable(policy) and not isinstance(policy, Policy))
        maker: Callable[..., Policy] = policy if makes else lambda: policy
        name = getattr(policy, "known_as", "") or getattr(policy, "__name__", type(policy).__name__)
        return PolicySource(name, {"": maker}, {"kind": "object"})
    name = str(policy)
    if name in _installed():
        return _from_entry_point(name, _installed()[name])
    file, colon, class_name = name.rpartition(":")
    if colon and file.endswith(".py"):
        if not Path(file).is_file():
            raise UnknownPolicyError(f"policy {name!r} is not known: there is no file {file}")
        digest = hashlib.sha256(Path(file).read_bytes()).hexdigest()
        return PolicySource(name, {"": load_class(Path(file), class_name)}, {"kind": "file", "sha256": digest})
    if _AGENTS.is_file():
        found: PolicySource | None = _agents().find_agent(name)
        if found is not None:
            return found
    where = "" if _AGENTS.is_file() else f"; trained agents are found {_FROM_CLONE}"
    raise UnknownPolicyError(
        f"policy {name!r} is not known: no installed one, no training run's folder, no FILE.py:CLASS; "
        f"{closest(name, policy_names())}{where}"
    )


def make_policy(policy: Any, **context: Any) -> Policy:
    """A policy by name, FILE.py:CLASS, folder, class or object, made for the `context` of a task; see `context_of`.

    >>> make_policy("lqg", sensors="state").slow
    False
    """
    return find_policy(policy).make(**context)


def load(policy: Any, env: Any = None) -> Policy:
    """A policy by name, FILE.py:CLASS, folder or class, ready to act in the environment that it belongs in.

    The baselines and the trained agents know that environment: `env_id`, `env_kwargs`, `make_env()` and `make_vec(n)`.
    With `env`, any form of `DrillRig-v0`, the policy is made for its rig, sensors and slew limit, and one that was
    made for others is refused by name. Raises `ValueError` where there is no such policy, or `env` is not for it.

    >>> policy = load("lqg")
    >>> observation, info = policy.make_env().reset(seed=0)
    >>> action, memory = policy.predict(observation)
    """
    if env is None:
        return make_policy(policy)
    task = rig_environment(env).task
    made = make_policy(policy, **context_of(task))
    if isinstance(made, AtHome):
        made.check_env(env)
    return made


def context_of(task: Any) -> dict[str, Any]:
    """What a policy is made for, by keyword, from the task that it is to act in.

    Sensors that are a set go by its name, so that its noise and delay are known too; others by names of channels.
    """
    names = ("rig", "slew_limit", "control_period", "largest_reference")
    own = {name: getattr(task, name) for name in names}
    friction = task.scenario.friction
    if not friction.falls_as(task.scales.friction):  # else it is what policies go by where they are not told
        own["friction"] = friction
    return {"sensors": task.sensors.asked, **own, "fleet": task.scenario.rigs}


def load_class(file: Path, name: str) -> type:
    """A class from a Python file, which may import from its own folder. `UnknownPolicyError` for none of that name."""
    module = load_module(file)
    classes = [key for key, value in vars(module).items() if getattr(value, "__module__", None) == module.__name__]
    classes = [key for key in classes if inspect.isclass(getattr(module, key))]
    if name not in classes:
        raise UnknownPolicyError(f"{file} has no class {name!r}; {closest(name, classes)}")
    found: type = getattr(module, name)
    return found


@lru_cache(maxsize=1)
def _installed() -> Mapping[str, EntryPoint]:
    """Entry points by name; a name of the project's own stays its own where another package offers it too."""
    entries = sorted(entry_points(group=GROUP), key=_is_own)
    return {entry.name: entry for entry in entries}


def _from_entry_point(name: str, entry: EntryPoint) -> PolicySource:
    about = (
        {"kind": "baseline"}
        if entry.dist is None or _is_own(entry)
        else {"kind": "installed", "package": entry.dist.name}
    )
    return PolicySource(name, {"": entry.load()}, about)


def _is_own(entry: EntryPoint) -> bool:
    return entry.dist is not None and entry.dist.name == "drillrig"


def _agents() -> Any:
    """The clone's own `agents`, whose name other packages have as well: never one from elsewhere."""
    if str(_CLONE) not in sys.path:
        sys.path.insert(0, str(_CLONE))
    return importlib.import_module("agents.policy.finding")
