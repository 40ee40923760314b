"""The environments that `benchmarks.environments` compares: how each is made, and its fixed action.

| name | single | many |
|---|---|---|
| `DrillRig-v0`, `DrillRigSurface-v0` | `gym.make` | `gym.make_vec`, native, on all cores |
| `DrillRig-v0, one core` | | the same with `threads=1` |
| `CartPole-v1` | `gym.make` | `gym.make_vec`, native, a few lines of NumPy |
| `Pendulum-v1` | `gym.make` | `gym.make_vec`, one after another, which is all it has |
| `Pendulum-v1, envpool` | a pool of one | a pool in C++, on all cores |
| `DC motor, gym-electric-motor` | `gym.make` | none: it is a single environment |
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium.vector.utils import batch_space

import drillrig_env  # noqa: F401  # registers the environments

LARGEST = 65_536
OURS = "DrillRig-v0"

Action = int | npt.NDArray[Any]
Environment = Any
"""A `gym.Env`, a `gym.vector.VectorEnv` or something that steps like one."""


@dataclass(frozen=True)
class Peer:
    """One environment to be timed.

    `make(n)` gives n copies (n = 1: the single form). `action` is one copy's fixed action, `episode` its steps
    an episode (`None`: it ends by its state), `smallest` and `largest` bound n. `package` is what must
    be installed, by the name to import and the one to install.
    """

    name: str
    make: Callable[[int], Environment]
    action: Action
    episode: int | None
    about: str
    largest: int = LARGEST
    smallest: int = 1
    package: tuple[str, str] | None = None

    def missing(self) -> str | None:
        """What to install first, in words; `None` where nothing is missing."""
        if self.package is None or find_spec(self.package[0]) is not None:
            return None
        return f"{self.name} is left out; install it with: pip install {self.package[1]}"


def _native(name: str, **arguments: Any) -> Callable[[int], Environment]:
    def make(count: int) -> Environment:
        if count == 1:
            return gym.make(name)
        return gym.make_vec(name, num_envs=count, vectorization_mode="vector_entry_point", **arguments)

    return make


def _pendulum(count: int) -> Environment:
    if count == 1:
        return gym.make("Pendulum-v1")
    return gym.make_vec("Pendulum-v1", num_envs=count, vectorization_mode="sync")


class Pool:
    """A pool of envpool with the batched action space that Gymnasium's vector environments have.

    envpool gives one copy's action space alone and takes its seed when it is made.
    """

    def __init__(self, name: str, count: int) -> None:
        self.pool = import_module("envpool").make(name, env_type="gymnasium", num_envs=count, seed=0)
        self.num_envs = count
        self.metadata = self.pool.metadata
        self.observation_space = batch_space(self.pool.observation_space, count)
        self.action_space = batch_space(self.pool.action_space, count)
        self.step = self.pool.step

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """Begin an episode in every copy; the seed was given when the pool was made."""
        return self.pool.reset(options=options)

    def close(self) -> None:
        """Let the pool go."""
        self.pool.close()


def _motor(_count: int) -> Environment:
    import_module("gym_electric_motor")  # registers its environments
    return gym.make("Cont-SC-PermExDc-v0")


def peers() -> list[Peer]:
    """Every environment, the project's first; see the module's table."""
    hold, push, rest = np.zeros(1, np.float32), 1, np.zeros(1)
    rig = "0.1 s of a stiff 7-state model with dry friction, many rigs on all cores; the speed reference is held"
    return [
        Peer(OURS, _native(OURS), hold, 600, rig),
        Peer(f"{OURS}, one core", _native(OURS, threads=1), hold, 600, "the same on one core", smallest=64),
        Peer("DrillRigSurface-v0", _native("DrillRigSurface-v0"), hold, 600, "the same with noise and delay", 4096),
        Peer("CartPole-v1", _native("CartPole-v1"), push, None, "4 states, one explicit step; pushed to the right"),
        Peer("Pendulum-v1", _pendulum, hold, 200, "2 states, one explicit step; no torque", 1024),
        Peer(
            "Pendulum-v1, envpool",
            lambda count: Pool("Pendulum-v1", count),
            hold,
            200,
            "the same in C++, on all cores; no torque",
            16_384,
            package=("envpool", "envpool"),
        ),
        Peer(
            "DC motor, gym-electric-motor",
            _motor,
            rest,
            None,
            "Cont-SC-PermExDc-v0: a DC motor and its load, 2 states, 0.1 ms a step by SciPy; no voltage",
            1,
            package=("gym_electric_motor", "gym-electric-motor"),
        ),
    ]
