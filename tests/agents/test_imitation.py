"""Imitation: the student comes to do what the teacher does, with what the student sees; and how a training begins."""

import numpy as np
import pytest
import torch
from stable_baselines3 import PPO, SAC

from agents.policy.environment import batch_of, make_environment
from agents.policy.run_folder import load_policy
from agents.training.actor import actor_of
from agents.training.imitation import Exact, Imitation, Teacher, imitate
from agents.training.settings import Training, checked_config
from agents.training.train import train
from agents.training.warm_up import stagger
from drillrig_env.policy import make_policy

LAW = """
import numpy as np


class Law:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.clip(1.5 * observation[:, [0]] - 0.7 * observation[:, [2]], -1.0, 1.0).astype(np.float32), None
"""
FEW = {"rounds": 3, "updates": 20, "last_updates": 100, "batch": 256, "learning_rate": 3e-3}
HARDLY = {"rounds": 2, "updates": 2, "last_updates": 2, "batch": 16}
SHORT = {"duration": 5.0, "threads": 1}


@pytest.fixture
def law(tmp_path):
    """A teacher that is a function of what it sees."""
    (tmp_path / "law.py").write_text(LAW)
    return f"{tmp_path / 'law.py'}:Law"


def student(kind=PPO, frames=2, **kwargs):
    torch.manual_seed(0)
    env = make_environment("DrillRig-v0", 16, 0, {**SHORT, **kwargs}, frames)
    few = {"n_steps": 8, "batch_size": 64} if kind is PPO else {"buffer_size": 100}
    return kind("MlpPolicy", env, device="cpu", seed=0, policy_kwargs={"net_arch": [32, 32]}, **few), env


def disagreement(model, env, law):
    """Mean difference of the student's and the teacher's actions over an episode of the student."""
    teacher, observation, found = make_policy(law), env.reset(), []
    for _ in range(batch_of(env).core.steps):
        action, _ = model.predict(observation, deterministic=True)
        found.append(np.abs(action - teacher.predict(observation[:, -12:])[0]).mean())
        observation, *_ = env.step(action)
    return float(np.mean(found))


@pytest.mark.parametrize("kind", [PPO, SAC])
def test_the_student_comes_to_act_like_the_teacher(kind, law):
    model, env = student(kind)
    before = disagreement(model, env, law)
    steps = []
    imitate(model, env, Imitation(law, **FEW), 0, steps.append)
    assert disagreement(model, env, law) < 0.3 * before
    assert steps == sorted(steps)
    assert steps[-1] == 3 * 50 * 16


def test_it_then_explores_with_the_spread_that_was_asked_for():
    for kind in (PPO, SAC):
        model, env = student(kind)
        imitate(model, env, Imitation("z_torque", **HARDLY, log_std=-3.0), 0)
        observation = torch.from_numpy(np.random.default_rng(0).normal(size=(5, 24)).astype(np.float32))
        spread = model.policy.log_std if kind is PPO else model.actor.get_action_dist_params(observation)[1]
        np.testing.assert_allclose(spread.detach().numpy(), -3.0)


def test_the_same_seed_imitates_the_same_and_a_stop_ends_it():
    weights = []
    for seed in (1, 1, 2):
        model, env = student()
        imitate(model, env, Imitation("z_torque", **HARDLY), seed)
        weights.append(actor_of(model).parameters[0].detach().numpy().copy())
    np.testing.assert_array_equal(weights[0], weights[1])
    assert not np.array_equal(weights[0], weights[2])

    def stop(steps):
        if steps > 50:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        imitate(*student(), Imitation("z_torque", **HARDLY), 0, stop)


def test_a_privileged_teacher_sees_what_the_student_does_not():
    env = make_environment("DrillRig-v0", 6, 0, {"sensors": "surface", "noise": 1.0, "delay": 3, **SHORT})
    exact, plain = Exact(batch_of(env).core), make_environment("DrillRig-v0", 6, 0, SHORT)
    env.reset(), plain.reset()
    for action in np.random.default_rng(0).uniform(-1.0, 1.0, (20, 6, 1)).astype(np.float32):
        env.step(action)
        seen, *_ = plain.step(action)
        np.testing.assert_array_equal(exact.observe(), seen)


@pytest.mark.parametrize(
    ("fields", "words"),
    [({"rounds": 0}, "rounds = 0"), ({"last_share": 1.5}, "last_share"), ({"learning_rate": 0.0}, "learning_rate")],
)
def test_impossible_imitations_are_refused(fields, words):
    with pytest.raises(ValueError, match=words):
        Imitation(**fields)


LATE = """
import numpy as np


class Late:
    def __init__(self, delay=0):
        self.delay = delay

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.full((len(observation), 1), 0.1 * self.delay, np.float32), None
"""


def test_a_teacher_that_is_told_the_delay_gets_each_rig_s_own(tmp_path):
    (tmp_path / "late.py").write_text(LATE)
    env = make_environment("DrillRig-v0", 40, 0, {"sensors": "surface", "delay": [1, 3], **SHORT})
    observation = env.reset()
    core, starts = batch_of(env).core, np.ones(40, dtype=bool)
    teacher = Teacher(Imitation(f"{tmp_path / 'late.py'}:Late", told_delay=True), core)
    assert set(core.episodes["delay"]) == {1, 2, 3}
    np.testing.assert_allclose(teacher.actions(observation, starts)[:, 0], 0.1 * core.episodes["delay"], rtol=1e-6)
    plain = Teacher(Imitation(f"{tmp_path / 'late.py'}:Late"), core)
    np.testing.assert_array_equal(plain.actions(observation, starts), 0.0)


def test_a_privileged_teacher_sees_nothing_late():
    with pytest.raises(ValueError, match=r"told_delay = True.*sees all at once"):
        Imitation(privileged=True, told_delay=True)


def test_an_unknown_field_of_an_imitation_is_named_with_the_closest_one():
    training = Training(hyperparams={"imitation": {"round": 2}})
    with pytest.raises(ValueError, match=r"unknown key round = 2; did you mean rounds"):
        checked_config(training)


def test_first_episodes_end_one_after_another():
    env = make_environment("DrillRig-v0", 10, 0, SHORT)
    env.reset()
    stagger(env)
    ended = []
    for step in range(50):
        _, _, over, _ = env.step(np.zeros((10, 1), np.float32))
        ended += [step + 1] * int(over.sum())
    assert ended == list(range(5, 51, 5))


@pytest.mark.slow
@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_the_actor_is_held_while_the_critic_warms_up(tmp_path, algorithm):
    """After a training that was all warm-up the actor is the one that imitated, and the critic is not."""
    few = {"n_envs": 4, "batch_size": 64, "frame_stack": 1, "imitation": {"teacher": "z_torque", **HARDLY}}
    few |= {"n_steps": 16, "n_epochs": 1} if algorithm == "ppo" else {"learning_starts": 0, "gradient_steps": 1}
    actors, critics = [], []
    for held in (0, 10**6):
        training = Training(
            algorithm,
            n_timesteps=256,
            hyperparams={**few, "critic_iterations": held},
            env_kwargs=SHORT,
            run_folder=tmp_path / f"{algorithm}_{held}",
            eval_freq=-1,
            tensorboard=False,
            progress=False,
        )
        model = load_policy(train(training)).model
        actors.append(actor_of(model).parameters[0].detach().numpy())
        critic = model.policy.value_net.weight if algorithm == "ppo" else model.critic.q_networks[0][0].weight
        critics.append(critic.detach().numpy())
    model, env = fresh(algorithm, few)
    imitate(model, env, Imitation("z_torque", **HARDLY), 0)
    imitated = actor_of(model).parameters[0].detach().numpy()
    np.testing.assert_array_equal(actors[1], imitated)
    assert not np.array_equal(actors[0], imitated)
    untouched = model.policy.value_net.weight if algorithm == "ppo" else model.critic.q_networks[0][0].weight
    assert not np.array_equal(critics[1], untouched.detach().numpy())


def fresh(algorithm, hyperparams):
    """The model of a training before its first step, and its environment."""
    from agents.training.train import new_model

    model = new_model(checked_config(Training(algorithm, n_timesteps=256, hyperparams=hyperparams, env_kwargs=SHORT)))
    return model, model.get_env()
