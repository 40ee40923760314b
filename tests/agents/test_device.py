"""What PyTorch trains on: refused where it is not there, and on a card as on the processor but for rounding."""

import numpy as np
import pytest
import torch

from agents.policy.run_folder import CHECKPOINT, load_policy, new_run, read_config, write_config
from agents.training.device import device_of
from agents.training.settings import Training, checked_config
from agents.training.train import new_model, resume, train
from tests.agents import tiny

CARDS = [
    pytest.param(name, marks=pytest.mark.skipif(not there, reason=f"no {name} here"))
    for name, there in (("cuda", torch.cuda.is_available()), ("mps", torch.backends.mps.is_available()))
]
ALL = {
    "imitation": {"rounds": 2, "updates": 2, "last_updates": 2, "batch": 16},
    "critic_iterations": 1,
    "anchor": 0.5,
    "frame_stack": 2,
}


def training(folder, algorithm, device):
    return Training(
        algorithm,
        n_timesteps=512,
        hyperparams={**{"ppo": tiny.PPO, "sac": tiny.SAC}[algorithm], **ALL},
        env_kwargs={"duration": 3.0},
        run_folder=folder,
        device=device,
        save_freq=128,
        eval_freq=256,
        eval_episodes=5,
        tensorboard=False,
        progress=False,
    )


@pytest.mark.parametrize("name", [card.values[0] for card in CARDS if card.marks[0].args[0]])
def test_a_device_that_is_not_there_is_refused_before_anything_is_written(name, tmp_path):
    with pytest.raises(ValueError, match=f"device = {name} is not allowed; allowed: what PyTorch finds here: cpu"):
        train(training(tmp_path / "run", "ppo", name))
    assert not (tmp_path / "run").exists()


def test_the_processor_is_what_runs_have_had_that_do_not_say(tmp_path):
    assert device_of({}) == torch.device("cpu")
    folder = train(training(tmp_path / "run", "ppo", "cpu"))
    assert read_config(folder)["device"] == "cpu"


@pytest.mark.parametrize("device", CARDS)
@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_a_card_trains_stops_and_goes_on_and_the_agent_acts_without_it(algorithm, device, tmp_path):
    folder = train(training(tmp_path / "whole", algorithm, device))
    config = read_config(folder)
    assert new_model(config).device.type == device
    agent = load_policy(folder)
    assert agent.model.device.type == "cpu"
    actions, _ = agent.predict(np.zeros((3, 12), np.float32))
    assert np.isfinite(actions).all()
    stopped = new_run(tmp_path, algorithm)
    asked = iter([False] * 68 + [True] * 100)  # the first 66 while it imitates
    write_config(stopped, checked_config(training(stopped, algorithm, device)))
    with pytest.raises(KeyboardInterrupt):
        resume(stopped, progress=False, asked=lambda: next(asked))
    assert (stopped / CHECKPOINT).is_file()
    again, _ = load_policy(resume(stopped, progress=False)).predict(np.zeros((3, 12), np.float32))
    np.testing.assert_allclose(again, actions, atol=1e-2)
