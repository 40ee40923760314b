"""What is compared: a recipe for `ppo` with one piece of it changed, and what a newcomer trains."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from agents.setting import ScoredOn, Setting
from agents.training.hyperparameters import HYPERPARAMETER_FILES, hyperparameters
from agents.training.settings import Training
from agents.unknown import BESIDE, unknown

ENVIRONMENT = "DrillRig-v0"
"""Where all of them are trained: the rig's own drive."""

RECIPE = HYPERPARAMETER_FILES / "ablations" / "ppo.yml"
"""What is changed one piece at a time: how `ppo` was trained before the ablations led to other draws."""

_STEPS = 3_000_000  # of an ablation, by trial; what is imitated before comes on top
_NETWORK = "dict(net_arch=[{}], activation_fn=nn.ReLU)"
_SUM = {"tracking_shape": "absolute", "variance_shape": "absolute", "tracking": 0.2, "variance": 0.1, "action": 0.003}
"""The best known sum of terms: that of `agents/hyperparams/soft_drive/ppo.yml`."""

_ALONE = {
    "imitation": None,
    "critic_iterations": 0,
    "anchor": 0.0,
    "policy_kwargs": "dict(net_arch=[128, 128], activation_fn=nn.ReLU, log_std_init=-0.5)",
}
"""Hyperparameters of a network that knows nothing: no critic must catch up with it, and it explores more."""


@dataclass(frozen=True)
class Variant:
    """The recipe with a piece changed: fields of its scenario and its imitation, reward, hyperparameters."""

    name: str
    words: str
    scenario: Mapping[str, Any] = field(default_factory=dict)
    imitation: Mapping[str, Any] = field(default_factory=dict)
    reward: str | Mapping[str, Any] = "phases"
    hyperparams: Mapping[str, Any] = field(default_factory=dict)

    def setting(self) -> Setting:
        """The variant as a setting, everything else as in `RECIPE`."""
        recipe = hyperparameters("ppo", ENVIRONMENT, file=RECIPE)
        scenario = {**recipe["env_kwargs"]["scenario"], **self.scenario}
        hyperparams = {"imitation": {**recipe["imitation"], **self.imitation}, **self.hyperparams}
        training = Training(
            "ppo",
            ENVIRONMENT,
            n_timesteps=_STEPS,
            conf_file=RECIPE,
            hyperparams=hyperparams,
            env_kwargs={"scenario": scenario, "reward": self.reward},
            eval_freq=-1,
            tensorboard=False,
        )
        return Setting(self.name, self.words, training)


VARIANTS = (
    Variant("recipe", "the recipe: wide draws, the hardest of 5"),
    Variant("sum", "a sum of terms as reward, in place of phases", reward=_SUM),
    Variant("alone", "no imitation, and so no warm-up of the critic", hyperparams=_ALONE),
    Variant("no_warm_up", "no warm-up of the critic", hyperparams={"critic_iterations": 0}),
    Variant("candidates_1", "1 draw an episode, in place of the hardest of 5", {"candidates": 1}),
    Variant("frames_1", "1 frame, in place of 8", hyperparams={"frame_stack": 1}),
    Variant("default_draws", "normal forces and spread of `default`", {"normal_force": [5.0, 30.0], "spread": 0.2}),
    Variant(
        "shipped_draws",
        "draws as of the shipped `ppo`: between both, the hardest of 3",
        {"normal_force": [3.0, 36.0], "spread": 0.28, "candidates": 3},
    ),
    Variant("load_0", "no load steps, in place of 60 % of the episodes", {"load_step": 0.0}),
    Variant("gamma_99", "a discount of 0.99 a step, in place of 0.995", hyperparams={"gamma": 0.99}),
    Variant(
        "narrow",
        "a network of 64 by 64, in place of 128 by 128",
        hyperparams={"policy_kwargs": _NETWORK.format("64, 64")},
    ),
    Variant("less_exploration", "log-std -2 after imitation, in place of -0.7", imitation={"log_std": -2.0}),
    Variant("anchor", "held near what it imitated, with a weight of 1", hyperparams={"anchor": 1.0}),
    Variant("alone_sum", "neither imitation nor phases", reward=_SUM, hyperparams=_ALONE),
    Variant("frames_4", "4 frames, in place of 8", hyperparams={"frame_stack": 4}),
    Variant("candidates_3", "the hardest of 3 draws, in place of 5", {"candidates": 3}),
    Variant("load_30", "30 % load steps, in place of 60 %", {"load_step": 0.3}),
    Variant("gamma_98", "a discount of 0.98 a step, in place of 0.995", hyperparams={"gamma": 0.98}),
    Variant("wide_network", "a network of 256 by 128", hyperparams={"policy_kwargs": _NETWORK.format("256, 128")}),
)
"""The ablations, in order of what they tell."""

_RIGS = {1: '`gym.make("DrillRig-v0")`', 64: "`make_sb3(64)`"}
_REWARDS: dict[str, tuple[str, dict[str, Any]]] = {
    "": ("its reward", {}),
    "_phases": ('`reward="phases"`', {"reward": "phases"}),
}


def ablations() -> list[Setting]:
    """The recipe, and the same with one piece changed."""
    return [variant.setting() for variant in VARIANTS]


def newcomer() -> list[Setting]:
    """PPO and SAC with the settings that Stable-Baselines3 has by itself, on one rig and on many, for both rewards.

    One rig is trained on as the `VecEnv` of the project has it, which is bit for bit what `gymnasium.make` gives.
    """
    return [
        Setting(
            f"{algorithm}_{rigs}{ending}",
            f"{algorithm.upper()} on {where}, {reward}",
            Training(
                algorithm,
                ENVIRONMENT,
                hyperparams={"n_envs": rigs},
                env_kwargs=env_kwargs,
                conf_file=HYPERPARAMETER_FILES / "newcomer" / f"{algorithm}.yml",
                eval_freq=-1,
                tensorboard=False,
            ),
        )
        for algorithm in ("ppo", "sac")
        for rigs, where in reversed(_RIGS.items())
        for ending, (reward, env_kwargs) in _REWARDS.items()
    ]


COMPARISONS: dict[str, Callable[[], list[Setting]]] = {
    "ablations": ablations,
    "newcomer": newcomer,
    "unknown": unknown,
}
"""Every comparison by name, with what makes its settings."""

SCORED_ON = {"unknown": ScoredOn(("unknown",), "surface", BESIDE)}
"""What those comparisons are scored on that are not about one rig."""
