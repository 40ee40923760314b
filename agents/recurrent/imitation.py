"""Imitation with a memory: a recurrent network learns from whole episodes what a told controller does.

DAgger as in `agents.training.imitation`, over sequences: an episode is gone through in pieces, from its beginning on,
with the memory that the piece before has left (truncated backpropagation through time).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import torch
from stable_baselines3.common.vec_env import VecEnv

from agents.policy.environment import batch_of
from agents.recurrent.asymmetric import AsymmetricPPO
from agents.recurrent.through_estimates import ToldActor
from agents.recurrent.told import told_of
from agents.training.imitated import Imitated
from agents.training.imitation import Imitation, Teacher, imitation_cost, in_rounds, share_of_student

Episodes = tuple[torch.Tensor, torch.Tensor, torch.Tensor]
"""What was seen (steps, rigs, channels), the wanted actions (steps, rigs), what a critic is told (steps, rigs, ...)."""


def imitate_episodes(
    model: AsymmetricPPO,
    env: VecEnv,
    how: Imitation,
    seed: int,
    told: Callable[[int], object] = lambda _: None,
    file: Path | None = None,
) -> None:
    """Fit the actor of `model` to the teacher, in `env`, whose observations it must take.

    `how.batch` counts control steps, of whole pieces as long as the model's sequences. Draws follow from `seed`. `told`
    is called with the steps so far, several times a second; what it raises ends it. With `model` and `env` made anew
    and the same `file` it then goes on, and ends bit for bit as without the stop.
    """
    core = batch_of(env).core
    channels = len(core.sensors.channels)  # behind what an observer estimates
    teacher = Teacher(how, core)
    random = np.random.default_rng(seed)
    policy = model.policy
    told_actor = ToldActor(model) if model.through_estimates else None
    learning = [*policy.parameters(), *model.estimator.parameters()]
    learning += [] if told_actor is None else [*told_actor.first.parameters()]
    optimiser = torch.optim.Adam(learning, lr=how.learning_rate)
    episodes: list[Episodes] = []
    in_an_episode = core.steps // model.n_steps

    def pieces() -> Iterator[tuple[bool, Episodes]]:
        """Pieces of episodes without end, those of some rigs of a round in turn; and whether they begin with it."""
        rigs = min(max(1, how.batch // model.n_steps), env.num_envs)
        while True:
            played = episodes[random.integers(len(episodes))]
            chosen = torch.from_numpy(random.permutation(env.num_envs)[:rigs]).to(model.device)
            for begin in range(0, core.steps, model.n_steps):
                seen, wanted, so = (rows[begin : begin + model.n_steps, chosen] for rows in played)
                yield begin == 0, (seen, wanted, so)

    def play(number: int) -> None:
        student = random.random(env.num_envs) < share_of_student(how, number)
        policy.set_training_mode(False)
        observation, starts = env.reset(), np.ones(env.num_envs, dtype=np.bool_)
        assert isinstance(observation, np.ndarray)
        seen = torch.empty(core.steps, *observation.shape, device=model.device)
        wanted = torch.empty(core.steps, env.num_envs, device=model.device)
        so = torch.empty(core.steps, env.num_envs, model.told_channels, device=model.device)
        state = model.no_memory(env.num_envs)
        for step in range(core.steps):
            told((len(episodes) * core.steps + step) * env.num_envs)
            assert isinstance(observation, np.ndarray)
            actions = teacher.actions(observation[:, -channels:], starts)
            seen[step], wanted[step] = torch.from_numpy(observation), torch.from_numpy(actions[:, 0])
            so[step] = torch.from_numpy(told_of(env))
            with torch.no_grad():
                mean, state, _ = model.acts(seen[step : step + 1], state)
            own = mean[0].cpu().numpy().clip(-1.0, 1.0)[:, None]
            observation, _, starts, _ = env.step(np.where(student[:, None], own, actions))
        episodes.append((seen, wanted, so))

    def fit(done: int, updates: int, falling: bool) -> None:
        policy.set_training_mode(True)
        state, source = model.no_memory(1), pieces()
        for k in range(done, updates):
            if k % in_an_episode == 0:
                kept.remember(k)
            begins, (seen, wanted, so) = next(source)
            told(len(episodes) * core.steps * env.num_envs)
            if falling:
                optimiser.param_groups[0]["lr"] = how.learning_rate * (1.0 - k / updates)
            given, state, hidden = model.acts(seen, model.no_memory(seen.shape[1]) if begins else state)
            state = state[0].detach(), state[1].detach()
            given = given if told_actor is None else told_actor(so)
            cost = imitation_cost(given, wanted) + model.cost_of_estimates(hidden, so)
            optimiser.zero_grad()
            cost.backward()  # type: ignore[no-untyped-call]
            torch.nn.utils.clip_grad_norm_(learning, 1.0)
            optimiser.step()
        if told_actor is not None:
            told_actor.settle()

    parts = [model.policy, model.estimator, *([] if told_actor is None else [told_actor.first]), optimiser]
    kept = Imitated(parts, random, file)
    in_rounds(kept, how, play, fit)
    with torch.no_grad():
        model.policy.log_std.fill_(how.log_std)
