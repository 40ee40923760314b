"""Five tiny training seeds, and the agent that is shipped from them."""

import pytest

from agents.shipping.ship import ship
from agents.training.settings import Training
from agents.training.train import train
from tests.agents.tiny import PPO

TINY = {**PPO, "learning_rate": 0.01}


@pytest.fixture(scope="package")
def five_seeds(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "ppo"
    for seed in range(5):
        train(
            Training(
                seed=seed,
                n_timesteps=256,
                hyperparams=TINY,
                env_kwargs={"duration": 12.0},
                eval_freq=128,
                eval_episodes=3,
                run_folder=folder / f"seed_{seed}",
                tensorboard=False,
                progress=False,
            )
        )
    return folder


@pytest.fixture(scope="package")
def trained(five_seeds, tmp_path_factory):
    """A folder as agents/trained, with one shipped agent in it: `ppo`."""
    folder = tmp_path_factory.mktemp("shipped")
    ship(five_seeds, "ppo", 12, ["default", "load"], folder / "results", folder / "trained")
    return folder / "trained"
