"""Runs of recurrent PPO with a told critic: refused in time, kept, acting from a folder, and to begin with."""

import numpy as np
import pytest
import torch
from stable_baselines3.common.env_util import make_vec_env

pytest.importorskip("sb3_contrib")

from agents.policy.environment import make_environment
from agents.policy.run_folder import load_policy
from agents.training.fine_tuning import load_trainable
from agents.training.hyperparameters import algorithm_class
from agents.training.settings import Training
from agents.training.train import train
from drillrig_env import make_sb3
from drillrig_env.command_line import Failed
from drillrig_env.policy import check_policy, context_of
from tests.agents.tiny import ASYMMETRIC, FEW, SHORT

UNKNOWN = "DrillRigUnknown-v0"
IMITATION = {"teacher": "baselines/told.py:LQROfRig", "privileged": True, "rounds": 1, "updates": 1, "last_updates": 1}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"n_steps": 30}, "n_steps = 30 is not allowed"),
        ({"imitation": {**IMITATION, "privileged": False}}, "LQROfRig' cannot be imitated here: "),
        ({"imitation": {**IMITATION, "teacher": "baselines/told.py:LQROfRigs"}}, "cannot be imitated here: "),
        ({"observer": "baselines/told.py:LQGOfRig"}, "allowed: one that is told nothing; this one is told rig, "),
        (
            {"curriculum": {"scenarios": [{"load_step": 0.0}, {"tilt": {"share": 0.1, "turns": [1, 2]}}]}},
            "a tilted disc is not allowed",
        ),
    ],
)
def test_what_cannot_be_trained_is_refused_before_anything_is_written(tmp_path, changes, message):
    for fleet in (FEW, {"rigs": {"rigs": [{"J_1": 0.02}, {"J_1": 0.03}]}, "spread": 0.0}):
        training = Training(
            "ppo_asymmetric",
            UNKNOWN,
            n_timesteps=400,
            hyperparams={**ASYMMETRIC, **changes},
            env_kwargs={"duration": 4.0, "scenario": fleet},
            run_folder=tmp_path / "run",
        )
        with pytest.raises(ValueError, match=message):
            train(training)
    assert not list(tmp_path.iterdir())


def test_a_network_that_is_no_numbers_any_more_is_not_kept(tmp_path, monkeypatch):
    from agents.recurrent.asymmetric import AsymmetricPPO

    def diverges(self):
        with torch.no_grad():
            self.policy.action_net.weight.fill_(float("nan"))

    monkeypatch.setattr(AsymmetricPPO, "train", diverges)
    training = Training(
        "ppo_asymmetric",
        UNKNOWN,
        hyperparams={**ASYMMETRIC, "n_timesteps": 4000},
        env_kwargs={"duration": 4.0, "scenario": FEW},
        run_folder=tmp_path / "run",
        eval_freq=-1,
        tensorboard=False,
        progress=False,
    )
    with pytest.raises(Failed) as failed:
        train(training)
    assert "its weights are no numbers any more, and not kept" in "".join(failed.value.__notes__)
    assert not (tmp_path / "run" / "model.zip").exists()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return train(
        Training(
            "ppo_asymmetric",
            UNKNOWN,
            n_timesteps=640,
            hyperparams=ASYMMETRIC,
            env_kwargs={"duration": 4.0, "scenario": FEW},
            eval_freq=320,
            eval_episodes=4,
            run_folder=tmp_path_factory.mktemp("runs") / "run",
            tensorboard=False,
            progress=False,
        )
    )


def test_a_trained_one_acts_from_its_folder_and_learns_on(folder):
    agent = load_policy(folder)
    check_policy(agent, **context_of(agent.task))
    env = make_environment(UNKNOWN, 3, 5, SHORT)
    observation, state, memory = env.reset(), None, None
    for step in range(5):
        action, state = agent.predict(observation, state, np.full(3, step == 0))
        with torch.no_grad():
            memory = agent.model.no_memory(3) if memory is None else memory
            mean, memory, _ = agent.model.acts(torch.from_numpy(observation)[None], memory)
        np.testing.assert_allclose(action[:, 0], mean[0].clamp(-1, 1), atol=1e-6)
        observation, *_ = env.step(action)
    learner = algorithm_class("ppo_asymmetric").load(
        folder / "model.zip", env=make_environment(UNKNOWN, 8, 0, SHORT, told=True), device="cpu"
    )
    steps = learner.num_timesteps
    learner.learn(80, reset_num_timesteps=False)
    assert learner.num_timesteps == steps + 80


def trainable(folder, **changes):
    """The agent in an environment to learn on in."""
    given = {"env_id": UNKNOWN, "seed": 0, **SHORT, "privileged": True, **changes}
    return load_trainable(str(folder), make_sb3(8, **given))


def test_what_begins_with_it_has_its_critic_and_its_estimates_too(folder):
    theirs = algorithm_class("ppo_asymmetric").load(folder / "model.zip", device="cpu")
    begun = trainable(folder)
    for name in ("policy", "critic", "estimator"):
        own, taken = getattr(begun, name).state_dict(), getattr(theirs, name).state_dict()
        assert all(torch.equal(own[one], taken[one]) for one in taken), name
    before = begun.critic[0].weight.detach().clone()
    begun.learn(160)
    assert not torch.equal(begun.critic[0].weight, before)


def test_a_critic_that_is_told_of_other_things_begins_anew_and_that_is_said(folder):
    with pytest.warns(UserWarning, match="begins anew") as warned:
        begun = trainable(folder, scenario={"tilt": {"share": 0.1, "turns": [1, 2]}})
    assert [str(one.message).split(": ", 1)[1] for one in warned] == [
        f"its {name} begins anew: it has none that fits what is told here" for name in ("critic", "estimator")
    ]
    begun.learn(160)


def test_where_no_critic_can_be_told_is_refused(folder):
    with pytest.raises(ValueError, match=r"environment to learn on in = .*: what drillrig_env\.make_sb3 gives"):
        load_trainable(str(folder), make_vec_env("Pendulum-v1", 2))
    with pytest.raises(ValueError, match="privileged = False is not allowed; allowed: True: its critic is told more"):
        trainable(folder, privileged=False)
