"""To begin with an agent that knows something."""

import warnings
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

import drillrig_env
from agents.policy.run_folder import load_policy, read_config
from agents.training.fine_tuning import load_trainable
from agents.training.settings import Training
from agents.training.train import train
from drillrig_env.env.sensors import SENSORS
from tests.agents.tiny import PPO


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    hyperparams = {**PPO, "frame_stack": 2}
    folder = tmp_path_factory.mktemp("runs") / "first"
    return train(settings(folder, n_timesteps=512, hyperparams=hyperparams))


def settings(folder, **changes):
    quiet = {"eval_freq": -1, "tensorboard": False, "progress": False}
    return Training(**{"run_folder": folder, "env_kwargs": {"duration": 3.0}, **quiet, **changes})


def test_a_training_goes_on_from_an_agent_with_its_settings(run, tmp_path):
    again = train(
        settings(tmp_path / "again", n_timesteps=128, resume_from=str(run), hyperparams={"learning_rate": 1e-12})
    )
    config = read_config(again)
    assert config["resume_from"] == str(run)
    assert config["hyperparameters"]["frame_stack"] == 2
    assert config["hyperparameters"]["n_timesteps"] == 128
    observations = np.random.default_rng(0).normal(size=(9, 12)).astype(np.float32)
    actions = [load_policy(folder).predict(observations)[0] for folder in (run, again)]
    np.testing.assert_allclose(actions[0], actions[1], atol=1e-6)  # with hardly any rate it hardly changes


def test_it_learns_with_a_rate_that_begins_anew(run):
    model = load_trainable(str(run), drillrig_env.make_sb3(8, seed=0, duration=3.0), device="cpu")
    before = model.policy.action_net.weight.detach().numpy().copy()
    model.learn(256)
    assert model.observation_space.shape == (24,)
    assert not np.allclose(model.policy.action_net.weight.detach().numpy(), before)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"slew_limit": 0.75}, r"slew_limit = 0.75 and not 2 rad/s\^2$"),
        ({"control_period": 0.125}, "control_period = 0.125 and not 0.1 s$"),
        ({"drive": {"k_p": 0.05, "k_i": 0.01}}, "drive = {'k_p': 0.05, .*} and not {'k_p': 3.0, "),
        ({"sensors": SENSORS["state"].names[::-1]}, "sensors = string_torque_mean, .* and not twist_12, "),
    ],
    ids=["slew", "period", "drive", "sensors"],
)
def test_an_environment_in_which_it_begins_as_another_policy_is_warned_of(run, changes, told):
    with pytest.warns(UserWarning, match=f"begins as another policy than it was, .*: {told}"):
        load_trainable(str(run), drillrig_env.make_sb3(8, seed=0, **changes))


def test_what_it_is_to_learn_is_not_warned_of(run):
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        for changes in ({"noise": 1.0, "delay": (1, 4)}, {"reward": "phases"}, {"rig": {"J_1": 0.02}}):
            load_trainable(str(run), drillrig_env.make_sb3(8, seed=0, duration=3.0, **changes))
        load_trainable(str(run), drillrig_env.make_sb3(8, seed=0, rig="field_2500m"))  # in its scales
        load_trainable(str(run), VecNormalize(drillrig_env.make_sb3(8, seed=0), norm_obs=False))


def test_a_training_that_goes_on_elsewhere_is_warned_too(run, tmp_path):
    elsewhere = {"duration": 3.0, "slew_limit": 0.5}
    with pytest.warns(UserWarning, match=r"begins as another policy .*: slew_limit = 0.5 and not 2 rad/s\^2"):
        train(settings(tmp_path / "on", n_timesteps=128, resume_from=str(run), env_kwargs=elsewhere))


def test_what_does_not_fit_is_refused_by_name(run, tmp_path):
    with pytest.raises(ValueError, match=r"shape of the observations"):
        load_trainable(str(run), drillrig_env.make_sb3(8, seed=0, env_id="DrillRigSurface-v0"))
    for env in (gym.make("DrillRig-v0"), None):
        with pytest.raises(ValueError, match=r"environment to learn on in = .*: what drillrig_env\.make_sb3"):
            load_trainable(str(run), env)
    with pytest.raises(ValueError, match="ppo takes no argument 'learning_rat'; did you mean learning_rate"):
        load_trainable(str(run), drillrig_env.make_sb3(8, seed=0), learning_rat=1e-4)
    for change, message in (
        ({"gamma": 2}, "gamma = 2 is"),
        ({"n_epochs": 0}, "n_epochs = 0 is"),
        ({"clip_range": -1}, "-1"),
    ):
        with pytest.raises(ValueError, match=message):
            load_trainable(str(run), drillrig_env.make_sb3(8, seed=0), **change)
    with pytest.raises(ValueError, match="norm_obs of VecNormalize = True is not allowed; allowed: False"):
        load_trainable(str(run), VecMonitor(VecNormalize(drillrig_env.make_sb3(8, seed=0))))
    with pytest.raises(ValueError, match="env_id = DrillRigSurface-v0"):
        train(settings(tmp_path / "b", resume_from=str(run), env_id="DrillRigSurface-v0"))
    with pytest.raises(ValueError, match="algorithm = sac"):
        train(settings(tmp_path / "c", resume_from=str(run), algorithm="sac"))
    with pytest.raises(ValueError, match="neither a shipped agent nor the folder of a run"):
        train(settings(tmp_path / "d", resume_from="nobody"))
    with pytest.raises(ValueError, match="another network"):
        train(settings(tmp_path / "e", resume_from=str(run), hyperparams={"policy_kwargs": "dict(net_arch=[8])"}))
    with pytest.raises(ValueError, match=r"conf_file = mine\.yml is not allowed; allowed: none beside an"):
        train(settings(tmp_path / "f", resume_from=str(run), conf_file=Path("mine.yml")))
    with pytest.raises(ValueError, match=r"n_timesteps = 128 is not allowed; allowed: > 128 steps, in"):
        train(settings(tmp_path / "g", resume_from=str(run), n_timesteps=128, hyperparams={"critic_iterations": 1}))
    assert not list(tmp_path.iterdir())


def test_a_critics_part_is_refused(run):
    with pytest.raises(ValueError, match="privileged = True is not allowed; allowed: False: it has learnt from one"):
        load_trainable(str(run), drillrig_env.make_sb3(8, seed=0, privileged=True))
