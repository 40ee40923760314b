"""Terms of the reward of the user's own: the same in every form, compiled or in Python, and refused by name."""

import copy
import pickle
from pathlib import Path

import gymnasium as gym
import numba
import numpy as np
import pytest

from drillrig_env import Reward, RewardTerms, make_sb3
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.kernel import step_episodes
from drillrig_env.env.quantities import ENTRIES
from drillrig_env.env.reward_terms import MOST_TERMS
from drillrig_env.stepper.finite import NotFiniteError

STICKS = {"normal_force": 20.0, "speed_target": 2.0, "start": "stick_slip"}
PUSH = np.array([0.4], np.float32)


def off(bit_speed, speed_target, action, weight=0.3):
    return -abs(bit_speed - speed_target), -weight * action**2


@numba.njit
def top_power(current, top_speed):
    return -current * top_speed


OFF = RewardTerms(("off", "effort"), off)
SLOW_OFF = RewardTerms(("off", "effort"), off, compiled=False)
POWER = RewardTerms("power", top_power)

FILE = """
from drillrig_env import RewardTerms

def calm(bit_speed_highest, bit_speed_lowest):
    return bit_speed_lowest - bit_speed_highest

mine = RewardTerms("calm", calm)
"""


def played(reward, steps=30, **arguments):
    """Rewards and infos of the single environment from stick-slip."""
    env = gym.make("DrillRig-v0", reward=reward, **arguments)
    env.reset(seed=4, options=STICKS)
    return [env.step(PUSH) for _ in range(steps)]


def test_terms_are_what_the_function_says_of_the_episode():
    for _, reward, _, _, info in played(OFF):
        assert info["reward_off"] == pytest.approx(-abs(info["bit_speed"] - 2.0), rel=1e-12)
        assert info["reward_effort"] == pytest.approx(-0.3 * np.float64(PUSH[0]) ** 2, rel=1e-12)
        assert info["reward_variance"] == info["reward_tracking"] == info["reward_action"] == 0.0
        assert reward == info["reward_off"] + info["reward_effort"]


@pytest.mark.parametrize("base", [{}, {"form": "phases"}])
def test_own_terms_are_added_to_a_reward(base):
    alone, both = played(Reward(**base)), played(Reward(**base, own=OFF))
    for (seen, reward, *_), (seen_too, sum_of_both, *_, info) in zip(alone, both, strict=True):
        np.testing.assert_array_equal(seen, seen_too)
        assert sum_of_both == reward + info["reward_off"] + info["reward_effort"]


def test_actions_are_clipped_for_the_terms():
    env = gym.make("DrillRig-v0", reward=SLOW_OFF)
    env.reset(seed=0)
    assert env.step(np.array([5.0], np.float32))[4]["reward_effort"] == -0.3
    env.unwrapped.change(reward=OFF)
    assert env.step(np.array([-5.0], np.float32))[4]["reward_effort"] == -0.3


@pytest.mark.parametrize("first", range(0, len(ENTRIES), MOST_TERMS))
def test_every_entry_is_the_same_compiled_and_in_python(first):
    chosen = ENTRIES[first : first + MOST_TERMS]
    names = [entry.name for entry in chosen]
    made = {}
    exec(f"def function({', '.join(names)}): return ({', '.join(names)},)", made)
    terms = [RewardTerms([f"own_{name}" for name in names], made["function"], compiled=how) for how in (True, False)]
    envs = [gym.make_vec("DrillRig-v0", num_envs=3, reward=one, threads=1) for one in terms]
    for env in envs:
        env.reset(seed=2, options=STICKS)
    for _ in range(4):
        (_, reward, _, _, info), (_, reward_too, _, _, info_too) = (env.step(np.tile(PUSH, (3, 1))) for env in envs)
        np.testing.assert_array_equal(reward, reward_too)
        for entry in chosen:
            np.testing.assert_array_equal(info[f"reward_own_{entry.name}"], info_too[f"reward_own_{entry.name}"])
            np.testing.assert_array_equal(info[f"reward_own_{entry.name}"], entry.of(envs[0].core.episodes))
            if entry.name in info:
                np.testing.assert_array_equal(info[entry.name], info[f"reward_own_{entry.name}"])


@pytest.mark.parametrize("terms", [OFF, SLOW_OFF])
def test_forms_give_the_same_terms(terms):
    arguments = {"reward": terms, "duration": 1.0}
    single = [gym.make("DrillRig-v0", **arguments) for _ in range(2)]
    vector = gym.make_vec("DrillRig-v0", num_envs=2, autoreset_mode="SameStep", threads=2, **arguments)
    sb3 = make_sb3(2, seed=5, **arguments)
    for i, env in enumerate(single):
        env.reset(seed=5 + i)
    vector.reset(seed=5)
    sb3.reset()
    for step in range(10):
        rewards = [env.step(PUSH) for env in single]
        _, of_vector, _, _, info = vector.step(np.tile(PUSH, (2, 1)))
        _, of_sb3, _, infos = sb3.step(np.tile(PUSH, (2, 1)))
        info = info.get("final_info", info)
        for i, (_, reward, _, _, said) in enumerate(rewards):
            assert (reward, np.float32(reward)) == (of_vector[i], of_sb3[i])
            assert said["reward_off"] == info["reward_off"][i]
            assert said.keys() == {name for name in info if not name.startswith("_")}
        assert ("episode" in infos[0]) == (step == 9)


def test_python_terms_leave_episodes_that_are_over_alone():
    env = gym.make_vec("DrillRig-v0", num_envs=2, reward=SLOW_OFF, duration=0.5)
    env.reset(seed=0)
    for _ in range(3):
        env.step(np.tile(PUSH, (2, 1)))
    env.reset(options={"reset_mask": np.array([True, False])})
    rewards = [env.step(np.tile(PUSH, (2, 1)))[1] for _ in range(4)]
    assert rewards[2][1] == 0.0  # the step that begins the next episode
    assert all(reward.all() for reward in (*rewards[:2], rewards[3]))


def test_terms_are_changed_while_an_environment_lives():
    env = gym.make("DrillRig-v0").unwrapped
    env.reset(seed=4, options=STICKS)
    usual = env.step(PUSH)[4].keys()
    state = env.get_state()
    for terms in (OFF, SLOW_OFF):
        env.reward = terms
        assert env.step(PUSH)[4].keys() == {*usual, "reward_off", "reward_effort"}
    env.reward = POWER
    assert env.reward == Reward(0.0, 0.0, 0.0, own=POWER)
    _, reward, _, _, info = env.step(PUSH)
    assert info.keys() == {*usual, "reward_power"}
    assert reward == pytest.approx(-env.core.episodes["state"][0, 5] * info["top_speed"], rel=1e-12)
    env.set_state(state)
    assert env.step(PUSH)[4].keys() == usual
    many = make_sb3(2, seed=0)
    many.reset()
    many.set_attr("reward", {"own": POWER})
    many.step(np.tile(PUSH, (2, 1)))
    assert (many.core.info()["reward_power"] != 0.0).any()
    assert (many.core.info()["reward_action"] < 0.0).all()


@pytest.mark.parametrize("terms", [OFF, SLOW_OFF, POWER])
def test_copies_and_pickles_go_on_alike(terms):
    for again in (copy.deepcopy(terms), pickle.loads(pickle.dumps(terms))):
        assert again == terms
        assert hash(again) == hash(terms)
    env = gym.make("DrillRig-v0", reward=terms).unwrapped
    env.reset(seed=4, options=STICKS)
    env.step(PUSH)
    others = copy.deepcopy(env), pickle.loads(pickle.dumps(env))
    vectors = gym.make_vec("DrillRig-v0", num_envs=2, reward=terms)
    vectors.reset(seed=1)
    copied = pickle.loads(pickle.dumps(vectors))
    np.testing.assert_array_equal(*(each.step(np.tile(PUSH, (2, 1)))[1] for each in (vectors, copied)))
    expected = env.step(PUSH)
    for other in others:
        _, reward, _, _, info = other.step(PUSH)
        assert (reward, info) == (expected[1], expected[4])


def test_terms_differ_by_names_function_and_way():
    assert len({OFF, SLOW_OFF, RewardTerms(("off", "cost"), off), POWER}) == 4
    assert RewardTerms(["off", "effort"], off) == OFF


def test_terms_of_a_file_are_kept_by_their_name(tmp_path):
    (tmp_path / "terms.py").write_text(FILE)
    place = f"{tmp_path}/terms.py:mine"
    (tmp_path / "reward.toml").write_text(f'[reward]\nbase = "chapter"\nvariance = 0.0\nown = "{place}"\n')
    assert Reward.of(place) == Reward(0.0, 0.0, 0.0, own=place)
    assert Reward.of(tmp_path / "reward.toml").own == Reward.of({"own": place}).own
    own = pickle.loads(pickle.dumps(Reward.of(place))).own
    assert (str(own), own.names) == (place, ("calm",))
    for _, reward, _, _, info in played(place, 3):
        assert reward == info["reward_calm"] <= 0.0
    with pytest.raises(ValueError, match=r"no RewardTerms 'mien'; did you mean mine\?"):
        Reward.of(place.replace(":mine", ":mien"))
    with pytest.raises(ValueError, match="there is no file"):
        Reward.of("elsewhere.py:mine")


def test_time_constant_of_terms_alone_is_the_rigs():
    slow = gym.make("DrillRig-v0", reward=OFF, rig={"J_1": 0.08}).unwrapped
    assert slow.reward.time_constant > 2.5


def one(bit_speed):
    return -bit_speed


def two(bit_speed):
    return -bit_speed, 0


def undefined(bit_speed, speed_target):
    return 0.0, 0.0 / (speed_target - speed_target)


@numba.njit
def raises(bit_speed, speed_target):
    if speed_target > 0.0:
        raise ValueError("never")
    return 0.0, 0.0


def of_text(bit_speed):
    return "fine"


def of_anything(*given):
    return 0.0


def imports_within(bit_speed):
    import math

    return math.sqrt(bit_speed)


class Callable:
    def __call__(self, bit_speed):
        return bit_speed


@pytest.mark.parametrize(
    ("names", "function", "words"),
    [
        (("a", "b"), one, "number of terms = 1 is not allowed; allowed: one for each of a, b"),
        ("a", two, "number of terms = 2 is not allowed; allowed: one for each of a"),
        ("a", of_text, "what the function returns"),
        ("a", of_anything, "argument = [*]given is not allowed"),
        ("a", lambda bit_sped: 0.0, "unknown argument 'bit_sped'; did you mean bit_speed?"),
        ("a", lambda bit_speed: bit_speed.nothing, "RewardTerms a: the function cannot be compiled"),
        ("a", lambda bit_speed: unknown, "NameError: name 'unknown' is .*compiled=False leaves it"),  # noqa: F821
        ("a", imports_within, "the function cannot be compiled: Use of unsupported opcode"),
        ("a", Callable(), "function = .*Callable .*allowed: a function .*compiled=False"),
        ("a", 3.0, "function = 3.0"),
        ("tracking", one, "none of them variance, tracking, action"),
        (("a", "a"), two, "1 to 8 different names"),
        ((), one, "1 to 8 different names"),
        (("a b",), one, "words such as torque"),
        (3, one, "names = 3"),
    ],
)
def test_wrong_terms_are_refused(names, function, words):
    with pytest.raises(ValueError, match=words):
        RewardTerms(names, function)


def test_python_calls_whatever_can_be_called():
    assert RewardTerms("a", Callable(), compiled=False).arguments == ("bit_speed",)


@pytest.mark.parametrize("given", [3, "terms", one])
def test_what_is_no_terms_is_refused(given):
    with pytest.raises(ValueError, match="is not known; allowed: RewardTerms, or file"):
        Reward(own=given)
    with pytest.raises(ValueError, match="compiled = 1"):
        RewardTerms("a", one, compiled=1)


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (one, "number of terms = array.* is not allowed; allowed: one for each of a, b"),
        (lambda bit_speed: (bit_speed,), "number of terms = 1 is not allowed"),
        (lambda bit_speed: (bit_speed, bit_speed[:1]), r"term b = float64 of shape \(1,\) is not allowed; .*\(2,\)"),
        (lambda bit_speed: (0.0, np.array(["x", "y"])), "term b = <U1"),
    ],
)
def test_what_python_terms_give_is_refused_by_name(function, words):
    env = gym.make_vec("DrillRig-v0", num_envs=2, reward=RewardTerms(("a", "b"), function, compiled=False))
    env.reset(seed=0)
    with pytest.raises(ValueError, match=words):
        env.step(np.tile(PUSH, (2, 1)))


@pytest.mark.parametrize("compiled", [True, False])
def test_terms_that_are_not_finite_are_refused_by_name(compiled):
    terms = RewardTerms(("a", "b"), undefined, compiled=compiled)
    words = r"term b of the reward = nan of rig 0 \(seed 7\) at 0.1 s is not allowed; allowed: finite numbers"
    for env in (gym.make("DrillRig-v0", reward=terms), gym.make_vec("DrillRig-v0", num_envs=1, reward=terms)):
        env.reset(seed=7)
        action = PUSH if env.action_space.shape == (1,) else PUSH[None]
        with np.errstate(invalid="ignore"), pytest.raises(NotFiniteError, match=words):
            env.step(action)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_compiled_function_that_raises_gives_no_earlier_number():
    env = gym.make("DrillRig-v0", reward=RewardTerms(("a", "b"), raises))
    env.reset(seed=7)
    with pytest.raises(NotFiniteError, match="term a of the reward = nan"):
        env.step(PUSH)


def test_the_page_tells_every_argument():
    page = (Path(__file__).parents[2] / "docs" / "environment.md").read_text(encoding="utf-8")
    for entry in ENTRIES:
        assert f"| `{entry.name}` | {entry.unit} | {entry.meaning} |" in page


def test_no_kernel_is_compiled_for_terms():
    core = gym.make_vec("DrillRig-v0", num_envs=2, threads=1).unwrapped.core
    core.reset(np.arange(2), first_uniforms(0, 2))
    core.step(np.zeros((2, 1), np.float32))
    before = list(step_episodes.signatures)
    for terms in (OFF, POWER):
        core.change(reward=terms)
        core.step(np.zeros((2, 1), np.float32))
        assert (core.info()[f"reward_{terms.names[0]}"] != 0.0).any()
    assert list(step_episodes.signatures) == before
