"""States: what `get_state` gives and `set_state` goes on from, bit for bit, in all forms."""

import pickle

import gymnasium as gym
import numpy as np
import pytest

import drillrig_env
from drillrig_env.env.core import EpisodeBatch
from tests.env.test_copies import FORMS, NOISY, Player

UP = np.ones(1, np.float32)


def bare(player):
    return player.env.unwrapped if player.form != "sb3" else player.env


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("before", [0, 12, 30])
def test_going_back_and_on_again_is_bit_for_bit_the_same(form, before):
    player = Player(form)
    player.reset(seed=5)
    player.run(before)
    step, over, state = player.step, player.over, bare(player).get_state()
    kept = pickle.dumps(state)
    expected = player.run(40)
    for again in (state, pickle.loads(kept)):
        player.step, player.over = step, over
        bare(player).set_state(again)
        assert player.run(40) == expected
    assert pickle.dumps(state) == kept  # no step has changed it


@pytest.mark.parametrize("form", FORMS)
def test_another_environment_of_the_task_goes_on_from_it(form):
    player, other = Player(form), Player(form)
    player.reset(seed=5)
    other.reset(seed=6)
    player.run(12)
    bare(other).set_state(bare(player).get_state())
    other.step, other.over = player.step, player.over
    assert other.run(40) == player.run(40)


def test_a_state_from_before_the_first_reset_leaves_the_seed_to_the_reset():
    env = gym.make("DrillRig-v0").unwrapped
    state = env.get_state()
    env.reset(seed=3)
    env.set_state(state)
    with pytest.raises(gym.error.ResetNeeded):
        env.step(UP)
    first, _ = env.reset(seed=3)
    np.testing.assert_array_equal(first, gym.make("DrillRig-v0").reset(seed=3)[0])


def test_a_state_shows_its_observations():
    env = gym.make("DrillRigSurface-v0").unwrapped
    first, _ = env.reset(seed=0)
    np.testing.assert_array_equal(env.get_state().observations[0], first)
    seen = env.step(UP)[0]
    np.testing.assert_array_equal(env.get_state().observations[0], seen)


def test_info_after_set_state_is_that_of_the_episode():
    env = gym.make("DrillRig-v0", delay=(0, 5)).unwrapped
    env.reset(seed=1)
    state, expected = env.get_state(), env.step(UP)[-1]
    env.reset(seed=2)
    env.set_state(state)
    assert env.step(UP)[-1] == expected


def test_scenario_reward_and_slew_limit_are_those_of_the_state_again():
    env = gym.make("DrillRig-v0").unwrapped
    env.reset(seed=0)
    state = env.get_state()
    env.change(reward={"action": 2.0}, slew_limit=1.0, scenario="wide")
    changed = env.step(UP)
    env.set_state(state)
    assert (env.slew_limit, env.reward.action, env.scenario.spread) == (2.0, 0.01, 0.2)
    assert env.step(UP)[1] != changed[1]


def test_sums_of_rewards_are_kept_for_the_report_of_an_episode():
    env = drillrig_env.make_sb3(2, seed=0, duration=1.0)
    env.reset()
    actions = np.zeros((2, 1), np.float32)
    for _ in range(5):
        env.step(actions)
    state = env.get_state()

    def reported():
        for _ in range(5):
            *_, infos = env.step(actions)
        return [info["episode"]["r"] for info in infos]

    expected = reported()
    env.set_state(state)
    assert reported() == expected


def of(form="DrillRig-v0", **arguments):
    env = gym.make(form, **arguments).unwrapped
    env.reset(seed=0)
    return env


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"sensors": "surface"}, "state's sensors"),
        ({"delay": 2}, "a state of delays up to 0 control steps is not allowed; allowed: up to 2"),
        ({"drive": (0.3, 0.2)}, "state's drive = None"),
        ({"duration": 30.0}, "state's duration = 60.0 is not allowed; allowed: 30.0"),
        ({"rig": {"k_p": 2.0}}, "state's rig"),
    ],
)
def test_a_state_of_another_task_is_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        of(**arguments).set_state(of().get_state())


def test_noise_and_delay_are_those_of_the_state_again():
    env = of(sensors="surface", noise=2.0, delay=3)
    state, other = env.get_state(), of(sensors="surface", noise=0.0, delay=(0, 3))
    other.set_state(state)
    assert (other.noise, other.delay) == (2.0, (3, 3))
    for _ in range(5):
        expected, *_ = env.step(np.ones(1, np.float32))
        found, *_ = other.step(np.ones(1, np.float32))
        assert np.array_equal(found, expected)


def test_a_state_of_another_number_of_rigs_length_or_form_is_refused():
    two, three = (gym.make_vec("DrillRig-v0", num_envs=n) for n in (2, 3))
    with pytest.raises(ValueError, match="a state of 2 rigs is not allowed; allowed: 3"):
        three.set_state(two.get_state())
    short = gym.make_vec("DrillRig-v0", num_envs=2, max_episode_steps=50)
    with pytest.raises(ValueError, match="of 600 steps is not allowed; allowed: 50"):
        short.set_state(two.get_state())
    with pytest.raises(ValueError, match=r"DrillRigVectorEnv in the mode NextStep is not allowed; .*VecEnv"):
        drillrig_env.make_sb3(2).set_state(two.get_state())
    with pytest.raises(ValueError, match="what get_state"):
        of().set_state(None)


@pytest.mark.parametrize("mode", ["SameStep", "Disabled"])
def test_a_state_of_another_way_to_begin_episodes_is_refused(mode):
    next_step, other = (gym.make_vec("DrillRig-v0", num_envs=2, autoreset_mode=name) for name in ("NextStep", mode))
    next_step.reset(seed=0)
    before = next_step.core.episodes.copy()
    other.reset(seed=1)
    with pytest.raises(ValueError, match=f"in the mode {mode} is not allowed; allowed: .*mode NextStep"):
        next_step.set_state(other.get_state())
    np.testing.assert_array_equal(next_step.core.episodes, before)


@pytest.mark.parametrize("form", FORMS)
def test_an_error_names_the_seed_of_the_state(form):
    player, other = Player(form), Player(form)
    player.reset(seed=5)
    other.reset(seed=17)
    bare(other).set_state(bare(player).get_state())
    other.env.unwrapped.core.episodes["state"][0, 2] = np.nan
    with pytest.raises(FloatingPointError, match=r"of rig 0 \(seed 5\)"):
        other.run(1)


def test_the_batch_core_has_states_too():
    core = EpisodeBatch(2, **NOISY)
    state = core.get_state()
    core.episodes["speed_target"] = 3.0
    core.set_state(state)
    assert core.episodes["speed_target"].tolist() == [0.0, 0.0]
