"""What is tried where nobody knows the rig: one recipe with a memory, and the same with one piece changed at a time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from agents.setting import Setting
from agents.training.hyperparameters import HYPERPARAMETER_FILES, hyperparameters
from agents.training.settings import Training

ENVIRONMENT = "DrillRigUnknown-v0"
"""A fleet, seen from the surface: see docs/fleets.md."""

FOLDER = HYPERPARAMETER_FILES / "unknown"
"""The recipe with a memory, and the one with frames, each a file of its algorithm's name."""

BESIDE = {
    "constant": "action 0, same drive",
    "lqg": "`lqg`",
    "baselines/for_fleets.py:LQGOfFleet": "`lqg`, tuned on a fleet",
    "baselines/told.py:LQGOfRig": "`LQGOfRig`, told rig and law *",
    "baselines/lqr_on_ensemble.py:LQROnEnsemble": "`LQROnEnsemble`, told rig, law and delay *",
    "baselines/told.py:LQROfRig": "`LQROfRig`, told all, exact state *",
}
"""Policies that are scored on the same rigs, and what a table calls them; * is told what no real rig tells."""

_ROLLOUT = 102_400  # steps of the recipe between two updates
_MEMORY = "dict(lstm_hidden_size={}, enable_critic_lstm=False, net_arch=dict(pi=[128], vf=[]), activation_fn=nn.ReLU)"
_ALONE = {"imitation": None, "critic_iterations": 0}
_FIRM = {"teacher": "baselines/told.py:FirmLQROfRig"}
_FITTED = {"updates": 480, "last_updates": 8000, "batch": 3200}
_ON_TARGET = {"reward": {"form": "phases", "variance": 0.03, "tracking": 0.27, "action": 0.003}}
_EASY = {"string": 1.3, "inertias": 1.3, "friction": 1.3, "motor": 1.03}


@dataclass(frozen=True)
class Try:
    """A recipe with a piece changed: of its environment, its scenario, its imitation, its hyperparameters."""

    name: str
    words: str
    algorithm: str = "ppo_asymmetric"
    env: Mapping[str, Any] = field(default_factory=dict)
    scenario: Mapping[str, Any] = field(default_factory=dict)
    imitation: Mapping[str, Any] = field(default_factory=dict)
    hyperparams: Mapping[str, Any] = field(default_factory=dict)

    def setting(self) -> Setting:
        """The try as a setting, everything else as its algorithm's file in FOLDER has it."""
        file = FOLDER / f"{self.algorithm}.yml"
        recipe = hyperparameters(self.algorithm, ENVIRONMENT, file=file)
        scenario = {**recipe["env_kwargs"]["scenario"], **self.scenario}
        hyperparams = {"imitation": {**recipe["imitation"], **self.imitation}, **self.hyperparams}
        training = Training(
            self.algorithm,
            ENVIRONMENT,
            conf_file=file,
            hyperparams=hyperparams,
            env_kwargs={"scenario": scenario, **self.env},
            eval_freq=-1,
            tensorboard=False,
        )
        return Setting(self.name, self.words, training)


def _frames(count: int) -> Try:
    return Try(f"frames_{count}", f"the last {count} frames, and no memory", "ppo", hyperparams={"frame_stack": count})


TRIES = (
    Try("memory", "a memory (LSTM of 128): imitates the told regulator, then learns by trial"),
    Try(
        "imitation",
        "imitates the told regulator, and no more",
        hyperparams={"critic_iterations": 1, "n_timesteps": _ROLLOUT},
    ),
    Try("firm", "imitates a told regulator that is firmer near calm, `FirmLQROfRig`", imitation=_FIRM),
    Try("fitted", "imitates by seven times as many updates, of smaller batches", imitation=_FITTED),
    Try("alone", "no imitation", hyperparams={**_ALONE, "policy_kwargs": _MEMORY.format("128, log_std_init=-0.5")}),
    Try(
        "through_estimates",
        "the memory learns to tell rig, friction and state; what imitates is told that; and no more",
        hyperparams={"estimates": 1.0, "through_estimates": True, "critic_iterations": 1, "n_timesteps": _ROLLOUT},
    ),
    Try("estimates", "the memory also learns to tell rig, friction and state", hyperparams={"estimates": 1.0}),
    Try("observer", "what the filter of `lqg` estimates is seen as well", hyperparams={"observer": "lqg"}),
    Try(
        "observer_of_fleet",
        "what the filter of `lqg`, tuned on a fleet, estimates is seen as well",
        hyperparams={"observer": "baselines/for_fleets.py:LQGOfFleet"},
    ),
    Try("untold", "a critic that sees what the policy sees", hyperparams={"critic_told": False}),
    Try("on_target", "rewards being on target nine times as much as being calm", env=_ON_TARGET),
    Try(
        "together",
        "the firmer regulator, more updates, a memory that also learns to tell, on target rewarded: as what ships",
        env=_ON_TARGET,
        imitation={**_FIRM, **_FITTED},
        hyperparams={"estimates": 1.0},
    ),
    Try(
        "tuned",
        "settings that a search of an hour found: four epochs of larger batches, a higher rate",
        imitation={"log_std": -1.56},
        hyperparams={
            "learning_rate": "lin_0.000442",
            "gamma": 0.994,
            "gae_lambda": 0.954,
            "n_epochs": 4,
            "batch_size": 6400,
            "target_kl": 0.0169,
        },
    ),
    _frames(8),
    _frames(20),
    _frames(40),
    Try("nominal", "the nominal rig alone, in place of a fleet", scenario={"rigs": None, "spread": 0.2}),
    Try(
        "curriculum",
        "first rigs within a factor of 1.3, seen with a third of the noise and one step late",
        hyperparams={
            "curriculum": {
                "scenarios": [{"rigs": {"spread": _EASY, "count": 512}}],
                "noise": [0.33],
                "delay": [1],
                "share": 0.75,
            }
        },
    ),
)
"""The tries, in order of what they tell."""


def unknown() -> list[Setting]:
    """The recipe, and the same with one piece changed."""
    return [one.setting() for one in TRIES]
