"""Who competes: baselines by name, trained agents by their folder, and controllers of your own by file and class."""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import baselines
import drillrig_env
from drillrig_env.drive import Drive
from drillrig_env.env.sensors import Sensors
from drillrig_env.evaluation.contest import Contestant, Failure
from drillrig_env.evaluation.runner import Policy
from drillrig_env.evaluation.suites import SUITES, Suite
from drillrig_env.parameters import closest

if TYPE_CHECKING:
    from agents.policy.agent import Agent


def find_field(
    names: Sequence[str], env_id: str, slow: bool = False, say: Callable[[str], object] = print
) -> tuple[list[Contestant], list[Failure]]:
    """The contestants of these names, or all that suit the environment, and who cannot compete.

    Without names these are the baselines and the agents that come with the package. One that does not
    suit, or that is slow while `slow` is false, is then left out; `say` is called with a line that says why.
    """
    contestants, failures = [], []
    for name in names or [*baselines.BASELINES, *_shipped()]:
        if not (names or slow) and name in baselines.BASELINES and baselines.BASELINES[name].slow:
            say(f"{name} is left out: it is slow; --slow lets it in")
            continue
        try:
            contestants.append(find_contestant(name, env_id, _label(name, names)))
        except Exception as error:  # a stranger's file may raise anything
            if names:
                failures.append(Failure.of(name, "", error))
            else:
                say(f"{name} is left out: {error}")
    return contestants, failures


def find_contestant(name: str, env_id: str, label: str) -> Contestant:
    """A baseline by name, a trained agent or several seeds by their folder, or FILE.py:CLASS.

    Made once here, so that one that cannot be made is known early. `ValueError` where the name is
    nothing of all that; beyond it, whatever the policy itself raises.
    """
    env = drillrig_env.ENVIRONMENTS[env_id]
    if name in baselines.BASELINES:
        return _from_class(label, baselines.BASELINES[name], env, {"kind": "baseline"})
    file, colon, class_name = name.rpartition(":")
    if colon and file.endswith(".py"):
        about = {"kind": "file", "sha256": hashlib.sha256(Path(file).read_bytes()).hexdigest()}
        return _from_class(label, load_class(Path(file), class_name), env, about)
    return _from_runs(name, label, env_id)


def load_class(file: Path, name: str) -> type:
    """A class from a Python file, which may import from its own folder. `ValueError` where it has none of that name."""
    spec = importlib.util.spec_from_file_location(file.stem, file)
    if spec is None or spec.loader is None:
        raise ValueError(f"{file} is not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[file.stem] = module
    sys.path.insert(0, str(file.parent.resolve()))
    try:
        spec.loader.exec_module(module)
    finally:
        sys.path.pop(0)
    classes = [key for key, value in vars(module).items() if inspect.isclass(value) and value.__module__ == file.stem]
    if name not in classes:
        raise ValueError(f"{file} has no class {name!r}; {closest(name, classes)}")
    found: type = getattr(module, name)
    return found


def _from_class(label: str, policy: type, env: Mapping[str, Any], about: Mapping[str, Any]) -> Contestant:
    """A baseline is made for the sensors and a suite's slew limit; any other class without arguments."""
    make = (
        partial(_for_suite, policy, env["sensors"]) if issubclass(policy, baselines.Baseline) else partial(_any, policy)
    )
    made = make(SUITES["default"](1))
    numbers = {
        key: value
        for key, value in vars(made).items()
        if isinstance(value, int | float | str) and not key.startswith("_") and key != "slew_limit"
    }
    privileged = tuple(getattr(made, "privileged", ()))
    drive = Drive.of(getattr(made, "drive", None))
    return Contestant(label, {"": make}, env, privileged, drive, {**about, "parameters": numbers})


def _from_runs(name: str, label: str, env_id: str) -> Contestant:
    """A trained agent, or all seeds of one algorithm in a folder, seen through the environment's own sensors."""
    from agents.policy.run_folder import find_run, is_run, load_policy, read_config, shipped

    seeds = sorted(path for path in Path(name).glob("*") if is_run(path))
    if not is_run(name) and not seeds and name not in shipped():
        known = [*baselines.BASELINES, *shipped()]
        raise ValueError(
            f"{name!r} is neither a baseline, nor a run's folder, nor FILE.py:CLASS; {closest(name, known)}"
        )
    folders = seeds if seeds and not is_run(name) else [find_run(name)]
    configs = {str(read_config(folder)["seed"]): read_config(folder) for folder in folders}
    kinds = {(config["algorithm"], config["env_id"], str(config["env_kwargs"])) for config in configs.values()}
    if len(configs) < len(folders) or len(kinds) > 1:
        raise ValueError(
            f"the runs in {name} are not the seeds of one algorithm: {sorted(kinds)}, seeds {list(configs)}"
        )
    agents = {str(agent.config["seed"]): agent for agent in map(load_policy, folders)}
    members = {seed: partial(_at_slew_limit, agents[seed]) for seed in sorted(agents, key=int)}
    shown, wanted = Sensors.named(drillrig_env.ENVIRONMENTS[env_id]["sensors"]), next(iter(agents.values())).sensors
    if missing := [channel for channel in wanted.names if channel not in shown.names]:
        raise ValueError(f"{label} sees {', '.join(missing)}, which the sensors of {env_id} do not show")
    env = {"sensors": wanted.names, "noise": shown.noise, "delay": shown.delay}
    drive = next(iter(agents.values())).drive
    return Contestant(label, members, env, (), drive, {"kind": "run", "configs": configs})


def _shipped() -> list[str]:
    """The agents that come with the package; PyTorch takes seconds to import, and only agents need it."""
    from agents.policy.run_folder import shipped

    return shipped()


def _for_suite(policy: type[baselines.Baseline], sensors: str, suite: Suite) -> Policy:
    return policy(sensors=sensors, slew_limit=suite.slew_limit)


def _any(policy: type, _suite: Suite) -> Policy:
    made: Policy = policy()
    return made


def _at_slew_limit(agent: Agent, suite: Suite) -> Policy:
    return agent.at_slew_limit(suite.slew_limit)


def _label(name: str, others: Sequence[str]) -> str:
    """The name in the tables: the last part of a path or the class of a file, or all of it where two end alike."""

    def last(full: str) -> str:
        return Path(full).name.rpartition(":")[2]

    return last(name) if [last(other) for other in others].count(last(name)) <= 1 else name
