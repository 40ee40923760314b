"""Imitation: a network learns what a controller from the physics does, before it learns by trial.

DAgger (Ross, Gordon & Bagnell, 2011): in every round all rigs play one episode, in the first under the teacher, later
ever more of them under the student; the teacher says all along what it would have done, and the student is fitted to
all that was said so far. So it learns from the states that it comes to itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecEnv

from agents.policy.environment import batch_of
from agents.training.actor import actor_of
from agents.training.imitated import Imitated
from agents.training.schedules import LEARNING_RATE
from drillrig_env.allowed import COUNT, SHARE, Allowed, Switch, Text
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.kernel import observe_episodes, scratch
from drillrig_env.env.sensors import SENSORS
from drillrig_env.parameters import check_fields, parameter, refuse
from drillrig_env.policy import context_of, make_policy, privileged_of
from drillrig_env.toml import record_of

_HUBER = 0.3  # error of an action from which on its cost grows linearly


@dataclass(frozen=True)
class Imitation:
    """How a network imitates a controller. `ValueError` for a field that is not allowed."""

    teacher: str = parameter("lqg", meaning="policy that is imitated", allowed=Text("the name of a policy"))
    privileged: bool = parameter(
        False, meaning="show the teacher the exact state at once, whatever the student sees", allowed=Switch()
    )
    told_delay: bool = parameter(
        False, meaning="tell the teacher how late each rig's measurements come, if it takes a `delay`", allowed=Switch()
    )
    rounds: int = parameter(8, meaning="rounds of one episode in every rig", allowed=COUNT)
    first_share: float = parameter(0.6, meaning="of the rigs that the student plays in the second round", allowed=SHARE)
    last_share: float = parameter(0.9, meaning="of those that it plays in the last", allowed=SHARE)
    updates: int = parameter(150, meaning="steps of the optimiser after each round", allowed=COUNT)
    last_updates: int = parameter(
        1200, meaning="steps of the optimiser at the end, with a rate that falls to zero", allowed=COUNT
    )
    batch: int = parameter(4096, meaning="observations in a step of the optimiser", allowed=COUNT)
    learning_rate: float = parameter(1e-3, meaning="of Adam", allowed=LEARNING_RATE)
    log_std: float = parameter(
        -2.0, meaning="logarithm of the spread of actions with which it then explores", allowed=Allowed(-10.0, 2.0)
    )

    def __post_init__(self) -> None:
        check_fields(self)
        if self.privileged and self.told_delay:
            raise refuse("Imitation", "told_delay", True, "", "False for a privileged teacher, who sees all at once")

    @classmethod
    def of(cls, given: Mapping[str, object]) -> Imitation:
        """An imitation from its fields. `ValueError` for an unknown one, with the closest known name."""
        return record_of(cls, "imitation", given)


def imitate(
    model: BaseAlgorithm,
    env: VecEnv,
    how: Imitation,
    seed: int,
    told: Callable[[int], object] = lambda _: None,
    file: Path | None = None,
) -> None:
    """Fit the actor of `model` to the teacher, in `env`, whose observations it must take.

    Draws follow from `seed`. `told` is called with the steps so far, several times a second; what it raises ends it.
    With `model` and `env` made anew and the same `file` it then goes on, and ends bit for bit as without the stop.
    """
    core = batch_of(env).core
    teacher = Teacher(how, core)
    random = np.random.default_rng(seed)
    actor = actor_of(model)
    optimiser = torch.optim.Adam(actor.parameters, lr=how.learning_rate)
    channels = len(core.sensors.channels)
    seen: list[npt.NDArray[np.float32]] = []
    said: list[npt.NDArray[np.float32]] = []

    def play(number: int) -> None:
        student = random.random(env.num_envs) < share_of_student(how, number)
        model.policy.set_training_mode(False)
        observation, starts = env.reset(), np.ones(env.num_envs, dtype=np.bool_)
        for _ in range(core.steps):
            told(len(seen) * env.num_envs)
            assert isinstance(observation, np.ndarray)
            wanted = teacher.actions(observation[:, -channels:], starts)
            with torch.no_grad():
                own = actor.mean(torch.from_numpy(observation).to(model.device)).cpu().numpy().clip(-1.0, 1.0)
            seen.append(observation.copy())
            said.append(wanted)
            observation, _, starts, _ = env.step(np.where(student[:, None], own, wanted))

    def fit(done: int, updates: int, falling: bool) -> None:
        model.policy.set_training_mode(True)
        observations, labels = (torch.from_numpy(np.concatenate(rows)).to(model.device) for rows in (seen, said))
        for k in range(done, updates):
            kept.remember(k)
            told(len(seen) * env.num_envs)
            if falling:
                optimiser.param_groups[0]["lr"] = how.learning_rate * (1.0 - k / updates)
            rows = torch.from_numpy(random.integers(len(labels), size=how.batch)).to(model.device)
            cost = imitation_cost(actor.mean(observations[rows]), labels[rows])
            optimiser.zero_grad()
            cost.backward()  # type: ignore[no-untyped-call]
            optimiser.step()

    kept = Imitated((model.policy, optimiser), random, file)
    in_rounds(kept, how, play, fit)
    actor.explore(how.log_std)


def in_rounds(
    kept: Imitated, how: Imitation, play: Callable[[int], object], fit: Callable[[int, int, bool], object]
) -> None:
    """Play every round and fit to all that was said so far, then fit once more; not to what `kept` has fitted.

    `play` is called with the number of a round, from 0, and `fit` with the updates that are done, how many there are to
    be, and whether their rate falls to zero.
    """
    with kept:
        for number in range(how.rounds + 1):
            kept.begin(number)
            last = number == how.rounds
            if not last:
                play(number)
            done = kept.updates(number)
            if done is not None:
                fit(done, how.last_updates if last else how.updates, last)
        kept.begin(how.rounds + 1)


def share_of_student(how: Imitation, number: int) -> float:
    """The share of rigs that the student plays in a round, counted from 0; the teacher plays all of the first."""
    grown = (number - 1) / max(1, how.rounds - 2)
    return how.first_share + (how.last_share - how.first_share) * grown if number else 0.0


class Teacher:
    """The controller that is imitated, beside the rigs of a batch: it remembers what it has seen of their episodes."""

    def __init__(self, how: Imitation, core: EpisodeBatch) -> None:
        self.core = core
        self.exact = Exact(core) if how.privileged else None
        shown = self.exact.sensors if self.exact else core.sensors
        context: dict[str, Any] = {**context_of(core.task), "sensors": shown}
        first, last = core.task.delays
        told: list[dict[str, int]] = [{"delay": delay} for delay in range(first, last + 1)] if how.told_delay else [{}]
        self._delays = [one.get("delay") for one in told]
        self._policies = [make_policy(how.teacher, **context, **one) for one in told]
        self._memories: list[Any] = [None] * len(told)
        self._tells = bool(privileged_of(self._policies[0]))

    def actions(self, observations: npt.NDArray[np.float32], starts: npt.NDArray[np.bool_]) -> npt.NDArray[np.float32]:
        """What it would do, shape (n, 1), given observations (n, channels) and where an episode has begun, (n,)."""
        shown = self.exact.observe() if self.exact else observations
        wanted = np.empty((len(shown), 1), dtype=np.float32)
        for k, (policy, delay) in enumerate(zip(self._policies, self._delays, strict=True)):
            if self._tells:
                policy.tell(self.core.info())  # type: ignore[attr-defined]
            found, self._memories[k] = policy.predict(shown, self._memories[k], starts, deterministic=True)
            rows = slice(None) if delay is None else self.core.episodes["delay"] == delay
            wanted[rows] = found[rows]
        return wanted


class Exact:
    """The exact states of a batch's rigs as the sensors "state" show them, without noise or delay."""

    def __init__(self, core: EpisodeBatch) -> None:
        self.core, self.sensors = core, SENSORS["state"]
        self._layout, self._past = (
            self.sensors.layout(0.0),
            np.empty((len(core), 0, len(self.sensors.channels)), np.float32),
        )

    def observe(self) -> npt.NDArray[np.float32]:
        """What the rigs are like now, shape (n, channels)."""
        seen = np.empty((len(self.core), len(self.sensors.channels)), dtype=np.float32)
        observe_episodes(self.core.episodes, self._layout, self._past, seen, scratch())
        return seen


def imitation_cost(given: torch.Tensor, wanted: torch.Tensor) -> torch.Tensor:
    """Huber's cost of actions; none where the wanted one is at its limit and the given one beyond it."""
    beyond = (wanted >= 1.0) & (given > 1.0) | (wanted <= -1.0) & (given < -1.0)
    return torch.nn.functional.huber_loss(torch.where(beyond, wanted, given), wanted, delta=_HUBER)
