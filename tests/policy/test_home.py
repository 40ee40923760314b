"""The environment that a policy belongs in: made by the policy, and told from one that differs."""

import re
import warnings
from functools import partial

import gymnasium as gym
import numpy as np
import pytest

import baselines
import drillrig_env
from drillrig_env import Drive
from drillrig_env.policy import load, make_policy
from tests.rigs import scaled


@pytest.mark.parametrize("name", ["lqg", "soft_torque", "ppo", "ppo_soft", "ppo_surface_soft"])
def test_every_form_of_its_environment_takes_a_policy(name):
    policy = load(name)
    env, many = policy.make_env(), policy.make_vec(3)
    observation, _ = env.reset(seed=0)
    observations, _ = many.reset(seed=0)
    actions, memory = policy.predict(observations)
    assert env.action_space.contains(policy.predict(observation)[0])
    assert actions.shape == (3, 1)
    many.step(actions)
    assert env.unwrapped.drive == many.unwrapped.drive == policy.drive
    again, _ = policy.predict(observations, memory, np.array([True, False, False]), deterministic=True)
    np.testing.assert_array_equal(again[0], actions[0])


def test_an_environment_that_differs_is_named():
    plain = gym.make("DrillRig-v0")
    assert load("lqg", env=plain).slew_limit == 2.0
    for name, kwargs, words in (
        ("ppo", {"drive": (0.1, 0.1)}, "the environment's drive"),
        ("ppo_soft", {}, "the environment's drive"),
        ("ppo", {"sensors": "surface"}, "the environment's sensors"),
    ):
        with pytest.raises(ValueError, match=words):
            load(name, env=gym.make("DrillRig-v0", **kwargs))
    with pytest.raises(ValueError, match=r"slew_limit = 1\.0 rad/s\^2"):
        make_policy("lqg").check_env(gym.make("DrillRig-v0", slew_limit=1.0))
    for change, told in (
        ({"noise": 1.0}, "noise = 1.0 and not None"),
        ({"delay": 2}, r"delay = \(2, 2\) and not None"),
        ({"control_period": 0.05}, "control_period = 0.05 and not 0.1 s"),
        ({"largest_reference": 10.0, "control_period": 0.25}, "control_period = 0.25 and not 0.1 s"),
        ({"largest_reference": 8.0}, "largest_reference = 8 and not 10 rad/s"),
        ({"rig": {"k_2": 0.4}}, r"rig.k_2 = 0.4 and not 0.3659 N m/rad"),
    ):
        with pytest.warns(UserWarning, match=f"lqg: the environment is not the one it was made for, .*: {told}"):
            make_policy("lqg").check_env(gym.make("DrillRig-v0", **change))


def test_an_agent_is_warned_of_another_period_and_a_controller_is_made_for_it():
    env = gym.make("DrillRig-v0", control_period=0.2)
    with pytest.warns(UserWarning, match="ppo: .*: control_period = 0.2 and not 0.1 s$"):
        load("ppo", env=env)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load("z_torque", env=env)


def test_a_policy_is_made_for_the_environment_that_is_given():
    env = gym.make("DrillRig-v0", slew_limit=1.0, rig={"k_2": 0.4})
    policy = load("lqg", env=env)
    assert (policy.slew_limit, policy.rig) == (1.0, env.unwrapped.rig)
    assert load("lqg", env=drillrig_env.make_sb3(2, slew_limit=0.5)).slew_limit == 0.5


def test_a_change_that_leaves_its_environment_is_refused_and_another_is_warned_of():
    with pytest.raises(ValueError, match="the environment's sensors"):
        load("ppo").make_env(sensors="encoders")
    with pytest.warns(UserWarning, match="delay"):
        load("lqg").make_vec(2, delay=1)


@pytest.mark.parametrize("policy", ["ppo", "agents/trained/sac", "z_torque", baselines.LQG, "FILE"], ids=str)
def test_every_warning_and_error_says_of_which_policy(policy, tmp_path):
    if policy == "FILE":
        (tmp_path / "mine.py").write_text("from baselines import Constant\nclass Mine(Constant): pass\n")
        policy = f"{tmp_path / 'mine.py'}:Mine"
    name = policy if isinstance(policy, str) else policy.__name__
    rig = {"k_1": 1.3, "J_3": 0.02}
    made = load(policy)
    for make in (made.make_env, partial(made.make_vec, 2)):
        said = re.escape(f"{name}: the environment is not the one it was made for")
        differs = re.escape(": rig.J_3 = 0.02 and not 0.0237 kg m^2, rig.k_1 = 1.3 and not 1.1175 N m/rad")
        with pytest.warns(UserWarning, match=f"^{said}.*{differs}$"):
            make(rig=rig)
    with pytest.raises(ValueError, match=re.escape(f"{name}: the environment's drive")):
        made.make_env(drive=(0.2, 0.1))
    assert load(made).known_as == name


def test_a_rig_that_is_another_altogether_is_told_by_its_first_parameters():
    with pytest.warns(UserWarning, match=r"rig.J_1 = .* and not 0.0288 kg m\^2, .* and \d+ more$"):
        load("z_torque").make_env(rig=scaled(time=0.25, torque=2.0))


def test_what_was_the_rigs_own_is_the_other_rigs_own():
    """A baseline asks for no slew limit but one that it was given, and one that differs is told as that rig has it."""
    rig = scaled(time=0.25, torque=2.0)
    policy = load("z_torque")
    with pytest.warns(UserWarning, match="z_torque"):
        assert policy.make_env(rig=rig).unwrapped.slew_limit == 32.0
    with pytest.raises(ValueError, match=r"slew_limit = 2\.0 rad/s\^2 .* make_env\(\), 32 rad/s\^2"):
        policy.make_env(rig=rig, slew_limit=2.0)
    for given in ({"slew_limit": 1.0}, {"largest_reference": 20.0}, {"control_period": 0.05, "largest_reference": 5.0}):
        assert make_policy("z_torque", **given).env_kwargs == given


@pytest.mark.parametrize("env", [gym.make("CartPole-v1"), "DrillRig-v0", 3], ids=["another", "its id", "a number"])
def test_what_is_no_rig_is_refused(env):
    for refused in (partial(load, "lqg"), load("z_torque").check_env):
        with pytest.raises(
            ValueError, match=r"policy: environment = .* is not allowed; allowed: any form of DrillRig-v0"
        ):
            refused(env)


@pytest.mark.parametrize("many", ["gymnasium", "sb3"])
def test_single_environments_side_by_side_are_taken_as_one_of_them(many):
    def one():
        return gym.make("DrillRig-v0", rig={"k_2": 0.39}, delay=3)

    if many == "sb3":
        env = pytest.importorskip("stable_baselines3.common.vec_env").DummyVecEnv([one, one])
    else:
        env = gym.vector.SyncVectorEnv([one, one])
    with pytest.warns(UserWarning, match=r"lqg: .*: delay = \(3, 3\) and not None"):
        assert load("lqg", env=env).rig.k_2 == 0.39
    with pytest.raises(ValueError, match=r"environment = .* any form of DrillRig-v0"):
        load("lqg", env=gym.vector.SyncVectorEnv([lambda: gym.make("CartPole-v1")]))


def test_a_policy_acts_on_a_scaled_rig_as_on_its_own():
    """Observations and slew limit are scaled, so that an agent's action means the same; and it may be asked of both."""
    rig = scaled(time=0.25, torque=2.0)
    own, elsewhere = gym.make("DrillRig-v0", duration=3.0), gym.make("DrillRig-v0", rig=rig, duration=0.75)
    for name in ("ppo", "lqg"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that the agent was made for another rig
            ours, theirs = load(name, env=own), load(name, env=elsewhere)
        seen, shown, memory, kept = own.reset(seed=2)[0], elsewhere.reset(seed=2)[0], None, None
        for _ in range(29):
            np.testing.assert_array_equal(seen, shown)
            action, memory = ours.predict(seen, memory)
            same, kept = theirs.predict(shown, kept)
            np.testing.assert_array_equal(action, same)
            seen, shown = own.step(action)[0], elsewhere.step(same)[0]


def test_a_soft_drive_of_an_agent_is_as_soft_on_a_scaled_rig():
    own, elsewhere = make_policy("ppo_soft").drive, make_policy("ppo_soft", rig=scaled(time=0.25, torque=2.0)).drive
    assert elsewhere == Drive(0.25 * own.k_p, own.k_i, own.back_emf_share)
    assert make_policy("ppo", rig=scaled(time=0.25)).drive is None


@pytest.mark.parametrize(
    ("sensors", "delay"),
    [("surface", 1), ("state", 0), (("top_speed", "current", "speed_target", "speed_reference"), 0)],
)
def test_a_policy_knows_how_late_the_sensors_are_that_it_is_made_for(sensors, delay):
    for rig in (None, scaled(2.0, 0.5)):
        env = gym.make("DrillRig-v0", sensors=sensors, rig=rig)
        assert load("lqg", env=env).delay == delay
        assert load("baselines/told.py:LQGOfRig", env=env).delay == 2 * delay  # of one to four, which it is not told
