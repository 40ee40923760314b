"""Recurrent PPO with an asymmetric critic: the policy remembers what it has seen, the critic is told what is so.

A policy on a rig that nobody knows must find out from late and noisy measurements what it is that it turns. A critic is
needed while it learns only, where the rig is simulated, so it may be told the exact state, load, friction and rig
(Pinto et al., Asymmetric Actor Critic for Image-Based Robot Learning, 2017). The network is that of sb3-contrib's
`MlpLstmPolicy`; what is learnt from is whole sequences, in which no episode begins: sb3-contrib's own loop clears
memories within a sequence step by step, and takes ten times as long.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import torch
from sb3_contrib import RecurrentPPO
from sb3_contrib.common.recurrent.type_aliases import RNNStates
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.utils import explained_variance
from stable_baselines3.common.vec_env import VecEnv
from torch import nn

from agents.policy.environment import batch_of
from agents.recurrent.sequences import Sequences, State
from agents.recurrent.told import TERMINAL, told_of
from drillrig_env.parameters import refuse

_WORTH = 0.1
"""A critic's output of 1 is a reward of so much in every step for ever: of the size that networks are made for."""


class AsymmetricPPO(RecurrentPPO):
    """Recurrent PPO over whole sequences, with a critic that is told everything.

    `n_steps` is the length of a sequence and must divide an episode's; `batch_size` counts control steps, and is made
    of whole sequences. `critic_arch` are the widths of the critic's hidden layers; not `critic_told`, it sees what is
    measured at the moment. With the weight `estimates` the memory also learns to tell what the critic is told, as far
    as it can be told from what was seen; with `through_estimates` it learns nothing else by imitation, and the layers
    behind it take what it tells for true (`agents.recurrent.through_estimates`). The environment is one of
    `agents.recurrent.told.ShowsPolicy`. Other arguments as those of `RecurrentPPO`; `policy_kwargs` should have
    `enable_critic_lstm=False`, since the policy's own critic is not used.
    """

    beside_policy = ("critic", "estimator")
    """What it learns with that is no part of its policy."""

    def __init__(
        self,
        policy: Any,
        env: Any,
        learning_rate: Any = 3e-4,
        n_steps: int = 100,
        batch_size: int = 25_600,
        n_epochs: int = 2,
        gamma: float = 0.995,
        gae_lambda: float = 0.97,
        clip_range: Any = 0.2,
        ent_coef: float = 0.0,
        max_grad_norm: float = 0.5,
        target_kl: float | None = None,
        critic_arch: Any = (128, 128),
        critic_told: bool = True,
        estimates: float = 0.0,
        through_estimates: bool = False,
        stats_window_size: int = 100,
        tensorboard_log: str | None = None,
        policy_kwargs: dict[str, Any] | None = None,
        verbose: int = 0,
        seed: int | None = None,
        device: torch.device | str = "auto",
        _init_setup_model: bool = True,
    ) -> None:
        super().__init__(
            policy,
            env,
            learning_rate=learning_rate,
            n_steps=n_steps,
            batch_size=batch_size,
            n_epochs=n_epochs,
            gamma=gamma,
            gae_lambda=gae_lambda,
            clip_range=clip_range,
            ent_coef=ent_coef,
            max_grad_norm=max_grad_norm,
            target_kl=target_kl,
            stats_window_size=stats_window_size,
            tensorboard_log=tensorboard_log,
            policy_kwargs=policy_kwargs,
            verbose=verbose,
            seed=seed,
            device=device,
            _init_setup_model=False,
        )
        if not 0.0 <= gamma < 1.0:
            raise refuse("AsymmetricPPO", "gamma", gamma, "", "0 to below 1: its critic foresees what goes on for ever")
        widths = critic_arch if isinstance(critic_arch, list | tuple) else (critic_arch, None)
        if not all(isinstance(width, int) and width > 0 for width in widths):
            raise refuse("AsymmetricPPO", "critic_arch", critic_arch, "", "a list of widths, whole and > 0")
        if through_estimates and not estimates:
            raise refuse("AsymmetricPPO", "estimates", estimates, "", "> 0 with through_estimates")
        self.critic_arch, self.critic_told = tuple(critic_arch), critic_told
        self.estimates, self.through_estimates = estimates, through_estimates
        self._last_lstm_states: Any
        self.clip_range: Any
        self.batch_size: int
        self.told_channels = self.measured_channels = 0  # none where it only acts
        if _init_setup_model:
            self._setup_model()

    def _setup_model(self) -> None:
        super()._setup_model()
        if self.through_estimates and not len(self.policy.mlp_extractor.policy_net):
            raise refuse("AsymmetricPPO", "net_arch", [], "", "a layer behind the memory, with through_estimates")
        lstm: Any = self.policy.lstm_actor
        with torch.no_grad():  # a memory that lasts, at first (Jozefowicz et al., 2015)
            for layer in range(lstm.num_layers):
                getattr(lstm, f"bias_ih_l{layer}")[lstm.hidden_size : 2 * lstm.hidden_size].fill_(1.0)
        assert self.observation_space.shape is not None
        self.measured_channels = self.measured_channels or self.observation_space.shape[0]
        if self.env is not None:
            self.told_channels = told_of(self.env).shape[1]
            self.measured_channels = len(batch_of(self.env).core.sensors.channels)  # without what a filter estimates
            self._check_sequences()
        if not self.told_channels:
            return
        widths = (self.told_channels if self.critic_told else self.measured_channels, *self.critic_arch)
        hidden = [layer for a, b in pairwise(widths) for layer in (nn.Linear(a, b), nn.ReLU())]
        self.critic = nn.Sequential(*hidden, nn.Linear(widths[-1], 1)).to(self.device)
        self.estimator = nn.Linear(lstm.hidden_size, self.told_channels).to(self.device)
        self.policy.optimizer.add_param_group({"params": self.estimator.parameters()})
        self.critic_optimizer = torch.optim.Adam(self.critic.parameters(), lr=self.lr_schedule(1.0), eps=1e-5)
        self.rollout_buffer: Any = Sequences(
            self.n_steps, self.n_envs, self.observation_space.shape[0], self.told_channels, self.device
        )

    def _setup_learn(self, *given: Any, **others: Any) -> Any:
        self._check_sequences()
        return super()._setup_learn(*given, **others)

    def _check_sequences(self) -> None:
        """Raise `ValueError` where sequences do not make up episodes, or batches no sequences."""
        assert self.env is not None
        steps = batch_of(self.env).core.steps
        if steps % self.n_steps:
            whole = [n for n in range(1, steps + 1) if steps % n == 0]
            near = {
                max(n for n in whole if n < self.n_steps),
                min((n for n in whole if n > self.n_steps), default=steps),
            }
            such_as = " or ".join(map(str, sorted(near)))
            allowed = f"a divisor of the {steps:,} steps of an episode, such as {such_as}"
            raise refuse("AsymmetricPPO", "n_steps", self.n_steps, "", allowed)
        if not self.n_steps <= self.batch_size <= self.n_steps * self.n_envs:
            allowed = f"{self.n_steps:,} to {self.n_steps * self.n_envs:,} steps: whole sequences"
            raise refuse("AsymmetricPPO", "batch_size", self.batch_size, "", allowed)

    def collect_rollouts(self, env: VecEnv, callback: BaseCallback, rollout_buffer: Any, n_rollout_steps: int) -> bool:
        """Play `n_rollout_steps` in all rigs with the policy as it explores, and fill the sequences."""
        self.policy.set_training_mode(False)
        callback.on_rollout_start()
        rollout: Sequences = rollout_buffer
        state: State = self._last_lstm_states.pi
        rollout.first = state
        spread = self.policy.log_std.detach()
        for step in range(n_rollout_steps):
            assert isinstance(self._last_obs, np.ndarray)
            rollout.observations[step] = torch.from_numpy(self._last_obs)
            rollout.told[step] = torch.from_numpy(told_of(env))
            with torch.no_grad():
                mean, state, _ = self.acts(rollout.observations[step : step + 1], state)
                noise = torch.randn_like(mean[0])
                rollout.actions[step] = mean[0] + spread.exp() * noise
                rollout.log_probs[step] = -0.5 * noise**2 - spread
            actions = rollout.actions[step].cpu().numpy()[:, None]
            observations, rewards, dones, infos = env.step(actions.clip(-1.0, 1.0))
            self._last_obs = observations  # type: ignore[assignment]  # one array, as `ShowsPolicy` has it
            self.num_timesteps += env.num_envs
            callback.update_locals(locals())
            if not callback.on_step():
                return False
            self._update_info_buffer(infos, dones)
            rollout.rewards[step] = torch.from_numpy(rewards)
            self._last_episode_starts = dones
        rollout.told[-1] = torch.from_numpy(told_of(env))
        ended = np.flatnonzero(dones)
        for rig in ended.tolist():
            rollout.told[-1, rig] = torch.from_numpy(infos[rig][TERMINAL])
        with torch.no_grad():
            forgotten = torch.from_numpy(ended).to(self.device)
            state = state[0].index_fill(1, forgotten, 0.0), state[1].index_fill(1, forgotten, 0.0)
            rollout.reckon(self._values(rollout.told), self.gamma, self.gae_lambda)
        self._last_lstm_states = RNNStates(state, state)
        callback.on_rollout_end()
        return True

    def train(self) -> None:
        """Update actor and critic from the last rollout, the actor as long as it stays near the one that played it."""
        self.policy.set_training_mode(True)
        self._update_learning_rate([self.policy.optimizer, self.critic_optimizer])
        rollout: Sequences = self.rollout_buffer
        advantages = (rollout.advantages - rollout.advantages.mean()) / (rollout.advantages.std() + 1e-8)
        parameters = [one for one in self.policy.parameters() if one.requires_grad]
        lstm: Any = self.policy.lstm_actor
        learns, divergence = lstm.weight_hh_l0.requires_grad, 0.0
        for _ in range(self.n_epochs):
            divergences = []
            for rigs in torch.randperm(self.n_envs).split(self.batch_size // self.n_steps):  # type: ignore[no-untyped-call]
                chosen = rigs.to(self.device)
                self._step_critic(rollout, chosen)
                if not learns:
                    continue
                loss, moved = self._cost(rollout, chosen, advantages[:, chosen])
                self.policy.optimizer.zero_grad()
                loss.backward()  # type: ignore[no-untyped-call]
                nn.utils.clip_grad_norm_(parameters, self.max_grad_norm)
                self.policy.optimizer.step()
                divergences.append(moved)
            if learns:
                divergence = float(torch.stack(divergences).mean())
                learns = self.target_kl is None or divergence <= 1.5 * self.target_kl
        self._n_updates += self.n_epochs
        returns = rollout.returns.flatten().cpu().numpy()
        foreseen = returns - rollout.advantages.flatten().cpu().numpy()
        self.logger.record("train/approx_kl", divergence)
        self.logger.record("train/std", float(self.policy.log_std.detach().exp().mean()))
        self.logger.record("train/explained_variance", explained_variance(foreseen, returns))

    def acts(self, observations: torch.Tensor, state: State) -> tuple[torch.Tensor, State, torch.Tensor]:
        """Mean actions, shape (steps, rigs), for `observations` (steps, rigs, channels); the memory after them; hidden.

        `state` is the memory before them, zeros where episodes begin. The last is what the network has of its memory in
        each step, (steps, rigs, hidden).
        """
        policy: Any = self.policy
        hidden, state = policy.lstm_actor(observations, state)
        return policy.action_net(policy.mlp_extractor.forward_actor(hidden)).squeeze(-1), state, hidden

    def cost_of_estimates(self, hidden: torch.Tensor, told: torch.Tensor) -> torch.Tensor | float:
        """What it costs that the memory `hidden` (steps, rigs, hidden) does not tell what is `told` (..., channels)."""
        if not self.estimates:
            return 0.0
        return self.estimates * nn.functional.mse_loss(self.estimator(hidden), told)

    def no_memory(self, rigs: int) -> State:
        """The memory of so many rigs whose episodes begin."""
        lstm: Any = self.policy.lstm_actor
        zeros = torch.zeros(lstm.num_layers, rigs, lstm.hidden_size, device=self.device)
        return zeros, zeros.clone()

    def _values(self, told: torch.Tensor) -> torch.Tensor:
        if not self.critic_told:
            told = told[..., -self.measured_channels :]  # the policy's part comes last
        return self.critic(told).squeeze(-1) * (_WORTH / (1.0 - self.gamma))  # type: ignore[no-any-return]

    def _step_critic(self, rollout: Sequences, rigs: torch.Tensor) -> None:
        worth = _WORTH / (1.0 - self.gamma)
        off = (self._values(rollout.told[:-1, rigs]) - rollout.returns[:, rigs]) / worth
        self.critic_optimizer.zero_grad()
        (off**2).mean().backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(self.critic.parameters(), 1.0)
        self.critic_optimizer.step()

    def _cost(
        self, rollout: Sequences, rigs: torch.Tensor, advantages: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """The clipped surrogate of PPO for some rigs, and how far the policy has moved (estimated KL divergence)."""
        state = rollout.first[0][:, rigs].contiguous(), rollout.first[1][:, rigs].contiguous()
        mean, _, hidden = self.acts(rollout.observations[:, rigs], state)
        log_std: Any = self.policy.log_std
        log_probs = -0.5 * ((rollout.actions[:, rigs] - mean) / log_std.exp()) ** 2 - log_std
        change = log_probs - rollout.log_probs[:, rigs]
        ratio = change.exp()
        clip = self.clip_range(self._current_progress_remaining)
        gained = torch.min(ratio * advantages, ratio.clamp(1.0 - clip, 1.0 + clip) * advantages)
        cost = -gained.mean() - self.ent_coef * log_std.sum() + self.cost_of_estimates(hidden, rollout.told[:-1, rigs])
        return cost, ((ratio - 1.0) - change).mean().detach()

    def _get_torch_save_params(self) -> tuple[list[str], list[str]]:
        dicts, variables = super()._get_torch_save_params()
        return [*dicts, *(("critic", "estimator", "critic_optimizer") if self.told_channels else ())], variables

    def _excluded_save_params(self) -> list[str]:
        return [*super()._excluded_save_params(), "critic", "estimator", "critic_optimizer"]
