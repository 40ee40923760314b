"""The anchor: the actor stays near the first model, the more so the stronger it is."""

import numpy as np
import pytest
import torch
from stable_baselines3 import SAC as SB3_SAC

from agents.policy.run_folder import FIRST_MODEL, load_policy
from agents.policy.weights import load_weights
from agents.training.settings import Training, checked_config
from agents.training.train import train
from tests.agents.tiny import PPO, SAC

FAST = {"ppo": {**PPO, "learning_rate": 0.01, "n_epochs": 4}, "sac": {**SAC, "learning_rate": 0.01}}


def moved(tmp_path, algorithm, **changes):
    """How far the actions have moved in a training, root of the mean square; and the trained agent's model."""
    folder = train(
        Training(
            algorithm,
            n_timesteps=512,
            hyperparams={**FAST[algorithm], **changes},
            env_kwargs={"duration": 3.0},
            run_folder=tmp_path / f"{algorithm}_{changes['anchor']:g}",
            eval_freq=-1,
            tensorboard=False,
            progress=False,
        )
    )
    agent = load_policy(folder)
    first = load_weights(folder / FIRST_MODEL, agent.config)
    seen = np.random.default_rng(0).normal(size=(200, 12)).astype(np.float32)
    before, after = (model.predict(seen, deterministic=True)[0] for model in (first, agent.model))
    return float(np.sqrt(np.mean((before - after) ** 2))), agent.model


@pytest.mark.slow
@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_the_stronger_the_anchor_the_nearer_it_stays(algorithm, tmp_path):
    weak, strong = (moved(tmp_path, algorithm, anchor=strength)[0] for strength in (1e-6, 1e3))
    assert 0.0 < strong < 0.5 * weak


@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_while_the_critic_warms_up_the_actor_does_not_move_at_all(algorithm, tmp_path):
    distance, model = moved(tmp_path, algorithm, anchor=1.0, critic_iterations=10_000)
    assert distance == 0.0
    critic = model.critic if algorithm == "sac" else model.policy.value_net
    assert all(torch.isfinite(parameter).all() for parameter in critic.parameters())


@pytest.mark.slow
def test_while_the_critic_warms_up_the_price_of_exploring_does_not_move_either(tmp_path):
    moved(tmp_path, "sac", anchor=1.0, critic_iterations=10_000)
    moved(tmp_path, "sac", anchor=2.0, critic_iterations=0)
    held, free = (SB3_SAC.load(tmp_path / f"sac_{k}" / "model.zip").log_ent_coef.item() for k in (1, 2))
    assert held == pytest.approx(np.log(0.01))  # auto_0.01
    assert abs(free - held) > 1e-3


def test_an_anchor_that_pushes_is_refused():
    with pytest.raises(ValueError, match=r"anchor = -1.*>= 0"):
        checked_config(Training(hyperparams={"anchor": -1.0}))
