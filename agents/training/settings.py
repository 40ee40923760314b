"""One training, every knob of it: a record of documented fields, and the config that it leads to."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from agents.policy.environment import (
    check_arguments,
    environment_arguments,
    plain_arguments,
    scaled_arguments,
    task_of,
)
from agents.policy.run_folder import find_run, read_config
from agents.training.calibrated import calibrated_arguments, calibrated_scenario, posterior_of
from agents.training.curriculum import Stages
from agents.training.device import DEVICES
from agents.training.hyperparameters import ALGORITHMS, TOLD, hyperparameters
from agents.training.imitation import Imitation, Teacher
from agents.training.warm_up import steps_held
from drillrig_env.allowed import COUNT, Allowed, Choice, File, Made, Switch, Text
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.scenario import Scenario
from drillrig_env.env.task import CHANGEABLE
from drillrig_env.parameters import check_fields, parameter, refuse
from drillrig_env.scales import Scales
from drillrig_env.seeds import TRAINING_FLEETS, TRAINING_SEEDS

_PARTS = 10
"""A training is evaluated, and its checkpoint written, this many times unless it is told otherwise."""

_TENTH = "a tenth of the training"


def _by_name(value: Any) -> dict[str, Any]:
    if not isinstance(value, Mapping) or not all(isinstance(name, str) for name in value):
        raise ValueError(f"{value!r} is not allowed; allowed: values by name")
    return dict(value)


_VALUES = Made(_by_name, "values by name")


@dataclass(frozen=True)
class Training:
    """One training run. `ValueError` for a field that is not allowed, with what is."""

    algorithm: str = parameter("ppo", meaning="the algorithm", allowed=Choice(ALGORITHMS))
    env_id: str = parameter("DrillRig-v0", meaning="environment id", allowed=Text("the id of an environment"))
    seed: int = parameter(0, meaning="seed of draws and networks", allowed=Allowed(0, TRAINING_SEEDS[-1], whole=True))
    n_timesteps: int | None = parameter(
        None, "steps", "length of the training", allowed=COUNT, none="as in the file of hyperparameters"
    )
    hyperparams: Mapping[str, Any] = parameter(
        factory=dict, meaning="changes to the file's hyperparameters", allowed=_VALUES
    )
    env_kwargs: Mapping[str, Any] = parameter(
        factory=dict,
        meaning="arguments of the environment, beside the file's; a rig may be the folder of a calibration",
        allowed=_VALUES,
    )
    conf_file: Path | None = parameter(
        None, meaning="file of hyperparameters", allowed=File(), none="agents/hyperparams/<algorithm>.yml"
    )
    resume_from: str | None = parameter(
        None,
        meaning="agent to begin with: its weights, and its settings where no others are given",
        allowed=Text("the name of an agent, or a run's folder"),
        none="an agent that knows nothing",
    )
    eval_freq: int | None = parameter(
        None, "steps", "distance between evaluations; negative: none", allowed=Allowed(whole=True), none=_TENTH
    )
    eval_episodes: int = parameter(200, "rigs", "how many an evaluation takes", allowed=COUNT)
    save_freq: int | None = parameter(None, "steps", "distance between checkpoints", allowed=COUNT, none=_TENTH)
    log_folder: Path = parameter(Path("runs"), meaning="parent of run folders", allowed=File())
    run_folder: Path | None = parameter(
        None,
        meaning="the run's own folder, which must not exist yet",
        allowed=File(),
        none="the next free one in the parent",
    )
    threads: int | None = parameter(
        None, meaning="threads that step the rigs; the result is the same", allowed=COUNT, none="all cores"
    )
    device: str = parameter("cpu", meaning="what PyTorch trains on", allowed=Choice(DEVICES))
    tensorboard: bool = parameter(True, meaning="write a TensorBoard log", allowed=Switch())
    progress: bool = parameter(True, meaning="show how the training does", allowed=Switch())

    def __post_init__(self) -> None:
        check_fields(self)
        if self.eval_freq == 0:
            raise refuse("Training", "eval_freq", 0, "steps", ">= 1, or negative for no evaluation")


def checked_config(training: Training) -> dict[str, Any]:
    """Everything that fixes a run, as plain values. `ValueError` for an unknown or impossible setting."""
    changes = dict(training.hyperparams)
    if training.n_timesteps is not None:
        changes["n_timesteps"] = training.n_timesteps
    base = _base(training)
    learnt = ("imitation", "curriculum")  # what an agent has behind it
    table = {name: value for name, value in base["hyperparameters"].items() if name not in learnt} if base else None
    chosen = hyperparameters(training.algorithm, training.env_id, changes, training.conf_file, table)
    given = base["env_kwargs"] if base else chosen.get("env_kwargs", {})
    own: dict[str, Any] = dict(training.env_kwargs)
    posterior = posterior_of(own.get("rig"))
    scales = Scales()
    if "rig" not in given:  # its numbers, and a curriculum's, are those of the chapter's rig
        scales = Scales.of(posterior.rig if posterior else own.get("rig"), own.get("largest_reference"))
    elif posterior:
        raise ValueError(f"{training.resume_from} has a rig of its own; allowed with a calibration: the chapter's")
    given = scaled_arguments(given, scales)
    if posterior:
        own |= calibrated_arguments(posterior, training.env_id, given, own, scales)
    env_kwargs = plain_arguments(training.env_id, {**given, **own})
    check_arguments(training.env_id, env_kwargs)
    _check_fleet(training.env_id, env_kwargs)
    if chosen.get("curriculum") is not None:
        scenarios = [scaled_arguments({"scenario": one}, scales) for one in chosen["curriculum"]["scenarios"]]
        if posterior:
            made = [Scenario.named(one["scenario"], scales) for one in scenarios]
            scenarios = [{"scenario": calibrated_scenario(posterior, one, scales)} for one in made]
        chosen["curriculum"]["scenarios"] = [plain_arguments(training.env_id, one)["scenario"] for one in scenarios]
        _check_stages(training.env_id, env_kwargs, Stages.of(chosen["curriculum"]), training.algorithm in TOLD)
    if chosen.get("imitation") is not None:
        _check_teacher(training.env_id, env_kwargs, Imitation.of(chosen["imitation"]))
    held = steps_held(training.algorithm, chosen)
    if base and chosen["n_timesteps"] <= held:
        allowed = f"> {held:,} steps, in which its critic learns alone, or fewer critic_iterations"
        raise refuse("Training", "n_timesteps", chosen["n_timesteps"], "", allowed)
    last = TRAINING_SEEDS[-1] - chosen["n_envs"]
    if training.seed > last:
        raise refuse("Training", "seed", training.seed, "", f"0 to {last}")
    part = max(1, chosen["n_timesteps"] // _PARTS)
    return {
        "algorithm": training.algorithm,
        "env_id": training.env_id,
        "env_kwargs": env_kwargs,
        "seed": training.seed,
        "hyperparameters": chosen,
        "eval_freq": training.eval_freq or part,
        "eval_episodes": training.eval_episodes,
        "save_freq": training.save_freq or part,
        "tensorboard": training.tensorboard,
        "device": training.device,
        "command": sys.argv,
        **({"resume_from": training.resume_from} if base else {}),
        **({"calibration": {**posterior.origin, "path": str(posterior.folder)}} if posterior else {}),
    }


def _base(training: Training) -> dict[str, Any] | None:
    """The config of the agent to begin with; None where there is none. `ValueError` where it is of another kind."""
    if training.resume_from is None:
        return None
    if training.conf_file is not None:
        allowed = "none beside an agent to begin with, whose settings hold but for --hyperparams and --env-kwargs"
        raise refuse("Training", "conf_file", str(training.conf_file), "", allowed)
    config = read_config(find_run(training.resume_from))
    for name in ("algorithm", "env_id"):
        if config[name] != getattr(training, name):
            raise refuse(
                "Training", name, getattr(training, name), "", f"{config[name]}, that of {training.resume_from}"
            )
    return config


def _check_fleet(env_id: str, env_kwargs: Mapping[str, Any]) -> None:
    """Raise `ValueError` for a fleet that is drawn by a seed of those that agents are judged or chosen on."""
    fleet = task_of(environment_arguments(env_id, env_kwargs)).scenario.rigs
    if fleet is not None and fleet.spread and fleet.seed not in TRAINING_FLEETS:
        allowed = f"{TRAINING_FLEETS[0]} to {TRAINING_FLEETS[-1]}, which nothing is judged on"
        raise refuse("Training", "seed of the fleet", fleet.seed, "", allowed)


def _check_stages(env_id: str, env_kwargs: Mapping[str, Any], stages: Stages, told: bool) -> None:
    """Raise `ValueError` for a stage of a curriculum that the environment cannot have, or not be changed to.

    Where a critic is `told`, what it is told has to stay the same.
    """
    batch = EpisodeBatch(1, **environment_arguments(env_id, env_kwargs), privileged=told)
    for stage in stages.environments(dict.fromkeys(CHANGEABLE))[:-1]:
        check_arguments(env_id, {**env_kwargs, **stage})
        _check_fleet(env_id, {**env_kwargs, **stage})
        batch.change(**stage)


def _check_teacher(env_id: str, env_kwargs: Mapping[str, Any], how: Imitation) -> None:
    """Raise `ValueError` for a teacher that cannot be made for the environment, or not act in it.

    It is tried on one rig of a fleet, since the design for hundreds takes a while.
    """
    arguments = environment_arguments(env_id, env_kwargs)
    scenario = task_of(arguments).scenario
    if scenario.rigs is not None:
        one = {"count": 1} if scenario.rigs.spread else {"rigs": scenario.rigs.rigs[:1], "friction": ()}
        arguments["scenario"] = replace(scenario, rigs=replace(scenario.rigs, **one))
    core = EpisodeBatch(1, **arguments)
    core.reset(np.arange(1), first_uniforms(0, 1))
    try:
        Teacher(how, core).actions(core.observations, np.ones(1, dtype=np.bool_))
    except (ValueError, RuntimeError, ArithmeticError) as error:
        raise ValueError(f"imitation: teacher {how.teacher!r} cannot be imitated here: {error}") from error
