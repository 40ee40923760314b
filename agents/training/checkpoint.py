"""Where an unfinished training goes on: one file with everything that its next step depends on.

A checkpoint is taken between two rollouts, when the last update is done and the next rollout has not
begun. It holds Stable-Baselines3's own model file (networks, optimisers, step count, the last
observations), the generators of PyTorch, NumPy and the action space, the state of the environment (every
rig's record and generator, and the scenario), what an observer remembers, the frame stack, SAC's replay
buffer and a recurrent network's state. A training that goes on from there ends, bit for bit, like one that
never stopped, with the same versions of PyTorch and NumPy on the same kind of machine; a graphics card may
round otherwise each time.
(With `use_sde` it does not: the exploration noise is drawn again at the start of a rollout.)

The file is written beside the old one and then put in its place, so that there is always a whole one. It
holds pickles, and reading those can run any code: go on with one's own trainings only.
"""

from __future__ import annotations

import io
import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.vec_env import VecEnv, VecFrameStack

from agents.policy.environment import batch_of
from agents.policy.observer import estimates_of
from agents.training.hyperparameters import algorithm_class
from drillrig_env.files import read_arrays, written_whole

Arrays = dict[str, np.ndarray]
_UNREADABLE = (KeyError, ValueError, AttributeError, ImportError, RuntimeError, TypeError, pickle.UnpicklingError)
_REPLAYED = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")


def save_checkpoint(path: Path, model: BaseAlgorithm) -> None:
    """Write where `model`, between two rollouts, stands."""
    env = model.get_env()
    assert env is not None
    saved = io.BytesIO()
    model.save(saved)
    arrays: Arrays = {
        "model": np.frombuffer(saved.getvalue(), dtype=np.uint8),
        "torch": torch.get_rng_state().numpy(),
        "generators": np.array(json.dumps(_generators(model))),
        "numpy": _numpy_generator().state["state"]["key"],
        "environment": np.frombuffer(pickle.dumps(batch_of(env).get_state()), dtype=np.uint8),
    }
    if isinstance(env, VecFrameStack):
        arrays["frames"] = env.stacked_obs.stacked_obs
    if (estimates := estimates_of(env)) is not None:
        arrays["observer"] = np.asarray(estimates.memory)
    if model.device.type == "cuda":
        arrays["cuda"] = torch.cuda.get_rng_state(model.device).numpy()
    buffer = getattr(model, "replay_buffer", None)
    if buffer is not None:
        filled = slice(None) if buffer.full else slice(0, buffer.pos)
        arrays.update({f"replay.{name}": getattr(buffer, name)[filled] for name in _REPLAYED})
        arrays["replay.position"] = np.array([buffer.pos, int(buffer.full)])
    arrays.update({f"lstm.{i}": tensor.cpu().numpy() for i, tensor in enumerate(_recurrent_state(model))})
    with written_whole(path) as new:
        np.savez(new, **arrays)  # type: ignore[arg-type]  # the stub takes a name for a flag


def load_checkpoint(path: Path, algorithm: str, env: VecEnv, device: torch.device | str = "cpu") -> BaseAlgorithm:
    """The model of a checkpoint, ready to learn on, on `device` and in `env`, which is brought to where it stood.

    `ValueError` naming the file where it is damaged, or of another version of the project or its packages.
    """
    remedy = "remove it, and --resume begins the training again"
    arrays = read_arrays(path, remedy)
    try:
        archive = io.BytesIO(arrays["model"].tobytes())
        model = algorithm_class(algorithm).load(archive, env=env, device=device, force_reset=False)
        batch_of(env).set_state(pickle.loads(arrays["environment"].tobytes()))
        if isinstance(env, VecFrameStack):
            env.stacked_obs.stacked_obs[...] = arrays["frames"]
        if (estimates := estimates_of(env)) is not None:
            estimates.memory = arrays["observer"]
        buffer = getattr(model, "replay_buffer", None)
        if buffer is not None:
            _fill(buffer, arrays)
        for i, tensor in enumerate(_recurrent_state(model)):
            tensor.copy_(torch.from_numpy(arrays[f"lstm.{i}"]))
        _restore_generators(model, json.loads(str(arrays["generators"])), arrays)
    except _UNREADABLE as error:
        raise ValueError(f"{path} is of another version or damaged ({error}); {remedy}") from error
    return model


def save_model(path: Path, model: BaseAlgorithm) -> None:
    """Write a model in Stable-Baselines3's own format, but for the folder of its log, which is this machine's."""
    with written_whole(path) as new:
        model.save(new, exclude=["tensorboard_log"])


def _generators(model: BaseAlgorithm) -> dict[str, Any]:
    """The states of the generators that are no arrays, as plain numbers; the key of NumPy's own goes into an array."""
    return {
        "numpy": _numpy_generator().state["state"]["pos"],
        "actions": model.action_space.np_random.bit_generator.state,
    }


def _numpy_generator() -> Any:
    """NumPy's own generator, from which Stable-Baselines3 draws its batches."""
    return np.random.get_bit_generator()  # type: ignore[attr-defined]  # its stubs leave it out


def _restore_generators(model: BaseAlgorithm, states: dict[str, Any], arrays: Arrays) -> None:
    state = {"key": arrays["numpy"], "pos": states["numpy"]}
    _numpy_generator().state = {"bit_generator": "MT19937", "state": state}
    torch.set_rng_state(torch.from_numpy(arrays["torch"]))
    if model.device.type == "cuda":
        torch.cuda.set_rng_state(torch.from_numpy(arrays["cuda"]), model.device)
    model.action_space.np_random.bit_generator.state = states["actions"]


def _fill(buffer: ReplayBuffer, arrays: Arrays) -> None:
    for name in _REPLAYED:
        saved = arrays[f"replay.{name}"]
        getattr(buffer, name)[: len(saved)] = saved
    position, full = arrays["replay.position"]
    buffer.pos, buffer.full = int(position), bool(full)


def _recurrent_state(model: BaseAlgorithm) -> list[torch.Tensor]:
    """Hidden and cell state of a recurrent network during training: of the actor, then of the critic."""
    states = getattr(model, "_last_lstm_states", None)
    return [] if states is None else [*states.pi, *states.vf]
