"""Begin with an agent that knows something: its weights in a model that learns on."""

from __future__ import annotations

import inspect
import warnings
from math import isclose
from typing import Any

from gymnasium import spaces
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecEnv, VecFrameStack, unwrap_vec_normalize

from agents.policy.agent import Agent
from agents.policy.environment import batch_of, environment_arguments, scaled_arguments
from agents.policy.observer import ShowsEstimates, estimates_of
from agents.policy.run_folder import MODEL, find_run, load_policy, read_config
from agents.policy.weights import give_saved
from agents.recurrent.told import ShowsPolicy
from agents.training.hyperparameters import TOLD, algorithm_arguments, algorithm_class, hyperparameters
from drillrig_env.drive import Drive
from drillrig_env.env.sb3 import DrillRigVecEnv
from drillrig_env.env.task import Task
from drillrig_env.parameters import closest, refuse
from drillrig_env.policy.home import rig_environment


def take_weights(model: BaseAlgorithm, name: str) -> None:
    """Give `model` the weights of an agent, by name or by its run's folder: those of its actor and of its critic.

    A warning names what in the model's environment lets observations and actions mean something else than where the
    agent learnt: drive, slew limit, control period, channels; another, that a critic begins anew, since it is told of
    other things here. `ValueError` where there is no such agent, or its network is another one.
    """
    folder = find_run(name)
    agent = load_policy(folder)
    trained = agent.model
    own, theirs = model.observation_space.shape, trained.observation_space.shape
    if own != theirs:
        raise refuse(name, "shape of the observations", own, "", f"{theirs}; check sensors and frames")
    try:
        model.policy.load_state_dict(trained.policy.state_dict())
    except RuntimeError as error:
        raise ValueError(f"{name} has another network than the one that is to begin with it") from error
    for beside in getattr(model, "beside_policy", ()):
        if not give_saved(getattr(model, beside), folder / MODEL, beside):
            warnings.warn(f"{name}: its {beside} begins anew: it has none that fits what is told here", stacklevel=3)
    if differs := _means_otherwise(agent, rig_environment(model.get_env()).task):
        warnings.warn(
            f"{name}: begins as another policy than it was, for the environment is not the one it learnt in: "
            f"{', '.join(differs)}",
            stacklevel=3,
        )


def _means_otherwise(agent: Agent, task: Task) -> list[str]:
    """What gives observations and actions another meaning in `task` than where the agent learnt, a text for each.

    An agent of the chapter's rig is held against what it learnt in taken to the scales of the rig.
    """
    given = agent.config["env_kwargs"]
    if "rig" not in given:
        own = {"rig": task.rig, "largest_reference": task.largest_reference}
        given = {**scaled_arguments(given, task.scales), **own}
    learnt = Task.of(environment_arguments(agent.config["env_id"], given))
    differs = [
        f"{what} = {getattr(task, what):g} and not {getattr(learnt, what):g} {unit}"
        for what, unit in (("slew_limit", "rad/s^2"), ("control_period", "s"))
        if not isclose(getattr(task, what), getattr(learnt, what), rel_tol=1e-9)
    ]
    drive, theirs = (one.drive or Drive.of_rig(one.rig) for one in (task, learnt))
    if drive != theirs:
        differs.append(f"drive = {drive.as_dict()} and not {theirs.as_dict()}")
    if task.sensors.names != learnt.sensors.names:
        differs.append(f"sensors = {', '.join(task.sensors.names)} and not {', '.join(learnt.sensors.names)}")
    return differs


def load_trainable(name: str, env: VecEnv, **changes: Any) -> BaseAlgorithm:
    """An agent, by name or by its run's folder, as a model of Stable-Baselines3 that learns on in `env`.

    `env` is what `drillrig_env.make_sb3` gives, with `privileged=True` for an agent whose critic is told more than it
    sees; the agent's observer and frames are put around it where they are missing.
    `changes` are arguments of the algorithm in place of those of the training, such as `learning_rate`; a rate that
    falls over a training begins anew at its start. An environment in which the agent begins as another policy is warned
    of. Raises `ValueError` where `env` is something else, shows something else or normalises what it shows, and for a
    change that the algorithm does not know.

    >>> model = load_trainable("ppo", drillrig_env.make_sb3(64, seed=0), learning_rate=1e-4)
    >>> model.learn(200_000)
    """
    config = read_config(find_run(name))
    told = config["algorithm"] in TOLD
    if not isinstance(env, VecEnv) or (told and not isinstance(env.unwrapped, DrillRigVecEnv)):
        raise refuse(name, "environment to learn on in", env, "", "what drillrig_env.make_sb3 gives")
    if (normalised := unwrap_vec_normalize(env)) is not None and normalised.norm_obs:
        raise refuse(name, "norm_obs of VecNormalize", True, "", "False: it has learnt from observations as they come")
    shown = isinstance(env.observation_space, spaces.Dict)
    if told and not isinstance(batch_of(env).observation_space, spaces.Dict):
        raise refuse(name, "privileged", False, "", "True: its critic is told more than it sees")
    if shown and not told:
        raise refuse(name, "privileged", True, "", "False: it has learnt from one array of observations")
    made: Any = algorithm_class(config["algorithm"])
    known = [argument for argument in inspect.signature(made).parameters if argument != "env"]
    for change in changes:
        if change not in known:
            raise ValueError(f"{name}: {config['algorithm']} takes no argument {change!r}; {closest(change, known)}")
    table, env_id = config["hyperparameters"], config["env_id"]
    plain = {one: value for one, value in changes.items() if one != "device" and not callable(value)}
    checked = hyperparameters(config["algorithm"], env_id, plain, table=table)
    chosen = {**checked, "device": "cpu", **{one: value for one, value in changes.items() if one not in plain}}
    if shown:
        env = ShowsPolicy(env)
    frames, observer = int(chosen.get("frame_stack", 1)), chosen.get("observer")
    if observer is not None and estimates_of(env) is None and not isinstance(env, VecFrameStack):
        env = ShowsEstimates(env, observer, batch_of(env).core.task)
    if frames > 1 and not isinstance(env, VecFrameStack):
        env = VecFrameStack(env, frames)
    model: BaseAlgorithm = made(env=env, **algorithm_arguments(chosen))
    take_weights(model, name)
    return model
