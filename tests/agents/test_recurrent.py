"""Recurrent PPO with a critic that is told: what it learns from, what is told to whom, and what it refuses."""

import numpy as np
import pytest
import torch

pytest.importorskip("sb3_contrib")

from agents.policy.environment import batch_of, make_environment
from agents.recurrent.imitation import imitate_episodes
from agents.recurrent.sequences import Sequences
from agents.recurrent.through_estimates import ToldActor
from agents.recurrent.told import TERMINAL, told_of
from agents.training.actor import actor_of
from agents.training.hyperparameters import algorithm_class, hyperparameters
from agents.training.imitation import Imitation, Teacher, imitation_cost, share_of_student
from agents.training.warm_up import WarmUp, stagger
from drillrig_env.env.privileged import PRIVILEGED
from tests.agents.tiny import SHORT

NETWORK = {"lstm_hidden_size": 8, "enable_critic_lstm": False, "net_arch": {"pi": [8], "vf": []}}


def environment(rigs=6, **changes):
    return make_environment("DrillRigUnknown-v0", rigs, 0, {**SHORT, **changes}, told=True)


def model(env, **changes):
    arguments = {"n_steps": 10, "batch_size": 30, "n_epochs": 1, "policy_kwargs": NETWORK, **changes}
    return algorithm_class("ppo_asymmetric")("MlpLstmPolicy", env, seed=0, device="cpu", **arguments)


def collected(learner, env, rollouts=1):
    """The sequences of the last of some rollouts, and the callback's model ready to train."""
    _, callback = learner._setup_learn(10_000, WarmUp(0, True), True, "run", False)
    callback.on_training_start({}, {})
    for _ in range(rollouts):
        learner.collect_rollouts(env, callback, learner.rollout_buffer, learner.n_steps)
    return learner.rollout_buffer


def test_returns_are_the_mean_of_all_that_a_critic_foresees():
    """The definition: returns of every length n, weighted with (1 - lambda) lambda^(n - 1), the last has the rest."""
    steps, gamma, lam = 7, 0.9, 0.8
    rollout = Sequences(steps, 3, 2, 4, torch.device("cpu"))
    torch.manual_seed(0)
    rollout.rewards, values = torch.randn(steps, 3), torch.randn(steps + 1, 3)
    rollout.reckon(values, gamma, lam)
    for begin in range(steps):
        found = torch.zeros(3)
        for n in range(1, steps - begin + 1):
            seen = sum(gamma**k * rollout.rewards[begin + k] for k in range(n)) + gamma**n * values[begin + n]
            last = n == steps - begin
            found += (lam ** (n - 1) if last else (1 - lam) * lam ** (n - 1)) * seen
        torch.testing.assert_close(rollout.returns[begin], found)
    torch.testing.assert_close(rollout.advantages, rollout.returns - values[:-1])


def test_the_policy_sees_what_it_would_on_a_rig_and_the_critic_what_is_so():
    env, bare = environment(), make_environment("DrillRigUnknown-v0", 6, 0, SHORT)
    np.testing.assert_array_equal(env.reset(), bare.reset())
    assert env.observation_space == bare.observation_space
    channels = len(batch_of(env).core.critic.channels)
    actions = np.random.default_rng(0).uniform(-1, 1, (60, 6, 1)).astype(np.float32)
    for action in actions:
        core = batch_of(env).core
        np.testing.assert_array_equal(told_of(env)[:, :channels], core.seen[PRIVILEGED])
        np.testing.assert_array_equal(told_of(env)[:, channels:], core.observations)
        (seen, rewards, dones, infos), expected = env.step(action), bare.step(action)
        for one, other in zip((seen, rewards, dones), expected[:3], strict=True):
            np.testing.assert_array_equal(one, other)
        if dones.all():
            break
    for info, other, fresh in zip(infos, expected[3], told_of(env), strict=True):
        np.testing.assert_array_equal(info["terminal_observation"], other["terminal_observation"])
        np.testing.assert_array_equal(info[TERMINAL][channels:], info["terminal_observation"])
        assert not np.array_equal(info[TERMINAL], fresh)  # the last state, not that of the next episode


def test_what_is_learnt_from_is_what_was_played():
    """The policy, run again over whole sequences from the memory with which they began, gives the same actions."""
    env = environment(12)
    learner = model(env)
    rollout = collected(learner, env, rollouts=3)
    everyone = torch.arange(12)
    cost, moved = learner._cost(rollout, everyone, torch.ones(10, 12))
    assert float(cost.detach()) == pytest.approx(-1.0, abs=1e-4)  # all ratios are 1
    assert float(moved) == pytest.approx(0.0, abs=1e-6)
    assert rollout.first[0].abs().max() > 0.0
    begun = torch.from_numpy(batch_of(env).core.episodes["step"] == 0)
    memory = learner._last_lstm_states.pi
    assert 0 < begun.sum() < 12
    for part in memory:
        assert (part[0, begun] == 0.0).all()
        assert (part[0, ~begun] != 0.0).all()


def test_a_value_beyond_a_time_limit_is_that_of_the_last_state():
    env = environment(4)
    learner = model(env)
    rollout = collected(learner, env, rollouts=4)  # every rig has ended an episode of 40 steps by now
    ended = np.flatnonzero(batch_of(env).core.episodes["step"] == 0)
    assert len(ended)
    for rig in range(4):
        fresh = np.array_equal(rollout.told[-1, rig].numpy(), told_of(env)[rig])
        assert fresh == (rig not in ended)


def test_episodes_begin_where_sequences_do():
    env = environment(9)
    stagger(env, 10)
    assert batch_of(env).core.episodes["step"].tolist() == [0, 0, 0, 10, 10, 20, 20, 30, 30]


def test_the_critic_learns_alone_while_the_actor_is_held():
    env = environment(8)
    learner = model(env, batch_size=40)
    before = {name: value.clone() for name, value in learner.policy.state_dict().items()}
    critic = [value.clone() for value in learner.critic.parameters()]
    learner.learn(80, WarmUp(1, False))
    assert all(torch.equal(value, before[name]) for name, value in learner.policy.state_dict().items())
    assert not any(torch.equal(*pair) for pair in zip(critic, learner.critic.parameters(), strict=True))
    learner.learn(80, WarmUp(1, False), reset_num_timesteps=False)
    assert not torch.equal(learner.policy.state_dict()["lstm_actor.weight_hh_l0"], before["lstm_actor.weight_hh_l0"])


def test_an_update_ends_where_the_policy_has_moved_far():
    moved = []
    for target in (None, 1e-9):
        env = environment(8)
        learner = model(env, batch_size=20, n_epochs=6, target_kl=target, learning_rate=1e-2)
        before = learner.policy.state_dict()["lstm_actor.weight_hh_l0"].clone()
        learner.learn(80)
        moved.append(float((learner.policy.state_dict()["lstm_actor.weight_hh_l0"] - before).abs().sum()))
    assert moved[1] < 0.7 * moved[0]


def test_the_memory_learns_to_tell_what_the_critic_is_told():
    off = []
    for weight in (1e-9, 1.0):
        env = environment(24)
        learner = model(env, batch_size=120, learning_rate=1e-2, estimates=weight)
        learner.learn(24 * 10 * 20)
        rollout = learner.rollout_buffer
        with torch.no_grad():
            _, _, hidden = learner.acts(rollout.observations, rollout.first)
            off.append(float(torch.nn.functional.mse_loss(learner.estimator(hidden), rollout.told[:-1])))
    assert off[1] < 0.5 * off[0]


def test_it_learns_what_pays():
    """With a reward for the action itself, the policy comes to choose it."""
    env = environment(32, reward={"variance": 0.0, "tracking": 0.0, "action": 1.0}, duration=2.0)
    learner = model(env, batch_size=160, n_epochs=4, learning_rate=1e-2, gamma=0.5)
    learner.learn(32 * 10 * 20)
    assert float(learner.policy.log_std.detach()) < -0.3


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"n_steps": 15}, "n_steps = 15 is not allowed; allowed: a divisor of the 40 steps of an episode, .* 10 or 20"),
        ({"n_steps": 80}, "allowed: a divisor of the 40 steps of an episode, such as 40"),
        ({"batch_size": 5}, "batch_size = 5 is not allowed; allowed: 10 to 60 steps: whole sequences"),
        ({"batch_size": 70}, "batch_size = 70 is not allowed; allowed: 10 to 60 steps"),
        ({"gamma": 1.0}, "gamma = 1.0 is not allowed; allowed: 0 to below 1"),
        ({"critic_arch": (8, -3)}, "critic_arch = .* allowed: a list of widths"),
        ({"critic_arch": 64}, "critic_arch = 64 is not allowed; allowed: a list of widths"),
    ],
)
def test_what_cannot_be_learnt_from_is_refused_before_anything_is_learnt(changes, message):
    with pytest.raises(ValueError, match=message):
        model(environment(), **changes)


def test_an_anchor_is_refused():
    with pytest.raises(ValueError, match=r"anchor = 1\.0 is not allowed"):
        hyperparameters("ppo_asymmetric", "DrillRigUnknown-v0", {"anchor": 1})


def test_the_student_comes_to_act_like_the_teacher():
    env = environment(24)
    learner = model(env)
    how = Imitation(
        "baselines/told.py:LQROfRig",
        privileged=True,
        rounds=3,
        updates=80,
        last_updates=400,
        batch=240,
        learning_rate=1e-2,
        log_std=-1.5,
    )

    def disagreement():
        core, teacher, observation = batch_of(env).core, Teacher(how, batch_of(env).core), env.reset()
        state, starts, found = learner.no_memory(24), np.ones(24, bool), []
        for _ in range(core.steps):
            wanted = torch.from_numpy(teacher.actions(observation, starts)[:, 0])
            with torch.no_grad():
                mean, state, _ = learner.acts(torch.from_numpy(observation)[None], state)
            found.append(float(imitation_cost(mean[0], wanted)))
            observation, _, starts, _ = env.step(mean[0].clamp(-1, 1).numpy()[:, None])
        return np.mean(found)

    before, told = disagreement(), []
    imitate_episodes(learner, env, how, 0, told.append)
    assert disagreement() < 0.5 * before
    assert told == sorted(told)
    assert len(told) > 3 * 40
    assert float(learner.policy.log_std.detach()) == pytest.approx(-1.5)
    assert actor_of(learner).parameters[0] is learner.policy.lstm_actor.weight_ih_l0


def test_through_estimates_it_acts_on_what_its_memory_tells_as_on_the_truth():
    env = environment(24)
    learner = model(env, estimates=1.0, through_estimates=True)
    untouched = learner.policy.mlp_extractor.policy_net[0].weight.detach().clone()
    how = Imitation("baselines/told.py:LQROfRig", privileged=True, rounds=2, updates=40, last_updates=200, batch=240)
    imitate_episodes(learner, env, how, 0)
    first, *others = learner.policy.mlp_extractor.policy_net
    assert not torch.equal(first.weight, untouched)
    assert np.linalg.matrix_rank(first.weight.detach()) <= learner.told_channels
    actor = ToldActor(learner)
    torch.nn.init.normal_(actor.first.weight)
    torch.nn.init.normal_(actor.first.bias)
    actor.settle()
    seen = torch.from_numpy(env.reset())[None]
    with torch.no_grad():
        mean, _, hidden = learner.acts(seen, learner.no_memory(24))
        torch.testing.assert_close(mean, actor(learner.estimator(hidden)))
        torch.testing.assert_close(first(hidden), actor.first(learner.estimator(hidden)))
    assert others[-1] is actor.others[-2]


def test_who_acts_through_estimates_must_learn_them():
    with pytest.raises(ValueError, match=r"estimates = 0\.0 is not allowed; allowed: > 0 with through_estimates"):
        model(environment(), through_estimates=True)


def test_the_memory_learns_to_tell_by_imitation_and_the_teacher_is_not_imitated_by_it():
    """With the layers behind it told the truth, the memory has no other aim than to tell it."""
    env = environment(24)
    learner = model(env, estimates=1.0, through_estimates=True)
    how = Imitation("baselines/told.py:LQROfRig", privileged=True, rounds=2, updates=20, last_updates=300, batch=240)

    def off():
        env.seed(0)
        observation, state, found = env.reset(), learner.no_memory(24), []
        for _ in range(30):
            with torch.no_grad():
                mean, state, hidden = learner.acts(torch.from_numpy(observation)[None], state)
                found.append(float(learner.cost_of_estimates(hidden[0], torch.from_numpy(told_of(env)))))
            observation, *_ = env.step(mean[0].clamp(-1, 1).numpy()[:, None])
        return np.mean(found)

    before = off()
    imitate_episodes(learner, env, how, 0)
    assert off() < 0.75 * before


def test_the_students_share_grows():
    how = Imitation(rounds=4, first_share=0.5, last_share=0.9)
    assert [share_of_student(how, number) for number in range(4)] == pytest.approx([0.0, 0.5, 0.7, 0.9])
