"""Begin with an agent that knows something: its weights in a model that learns on."""

from __future__ import annotations

import inspect
from typing import Any

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecEnv, VecFrameStack

from agents.policy.run_folder import find_run, load_policy, read_config
from agents.training.hyperparameters import algorithm_arguments, algorithm_class
from drillrig_env.parameters import closest, refuse


def take_weights(model: BaseAlgorithm, name: str) -> None:
    """Give `model` the weights of an agent, by name or by its run's folder: those of its actor and of its critic.

    `ValueError` where there is no such agent, or its network is another one.
    """
    trained = load_policy(find_run(name)).model
    own, theirs = model.observation_space.shape, trained.observation_space.shape
    if own != theirs:
        raise refuse(name, "shape of the observations", own, "", f"{theirs}; check sensors and frames")
    try:
        model.policy.load_state_dict(trained.policy.state_dict())
    except RuntimeError as error:
        raise ValueError(f"{name} has another network than the one that is to begin with it") from error


def load_trainable(name: str, env: VecEnv, **changes: Any) -> BaseAlgorithm:
    """An agent, by name or by its run's folder, as a model of Stable-Baselines3 that learns on in `env`.

    `env` is what `drillrig_env.make_sb3` gives; the agent's frames are put around it where they are missing.
    `changes` are arguments of the algorithm in place of those of the training, such as `learning_rate`; a rate that
    falls over a training begins anew at its start. Raises `ValueError` where `env` is something else or shows something
    else, and for a change that the algorithm does not know.

    >>> model = load_trainable("ppo", drillrig_env.make_sb3(64, seed=0), learning_rate=1e-4)
    >>> model.learn(200_000)
    """
    config = read_config(find_run(name))
    if not isinstance(env, VecEnv):
        raise refuse(name, "environment to learn on in", env, "", "what drillrig_env.make_sb3 gives")
    made: Any = algorithm_class(config["algorithm"])
    known = [argument for argument in inspect.signature(made).parameters if argument != "env"]
    for change in changes:
        if change not in known:
            raise ValueError(f"{name}: {config['algorithm']} takes no argument {change!r}; {closest(change, known)}")
    chosen = {**config["hyperparameters"], "device": "cpu", **changes}
    frames = int(chosen.get("frame_stack", 1))
    if frames > 1 and not isinstance(env, VecFrameStack):
        env = VecFrameStack(env, frames)
    model: BaseAlgorithm = made(env=env, **algorithm_arguments(chosen))
    take_weights(model, name)
    return model
