"""Laws of friction of the user's own: checked, carried along, and as exact as those that have a name."""

import copy
import pickle

import gymnasium as gym
import numba
import numpy as np
import pytest

from drillrig_env import Friction, Law, Rig, Scenario, simulate, simulate_batch
from drillrig_env.stability import critical_speed, eigenvalues, fold_speed, hopf_points, stable_speeds

RIG = Rig()
TURNING = (0.0, 0.0, 2.0, 2.0, 2.0, 0.5, 0.0)


def exponential(speed, mu_s, mu_k, v_b):
    return mu_k + (mu_s - mu_k) * np.exp(-v_b * speed)


def exponential_slope(speed, mu_s, mu_k, v_b):
    return -v_b * (mu_s - mu_k) * np.exp(-v_b * speed)


def exponential_curvature(speed, mu_s, mu_k, v_b):
    return v_b * v_b * (mu_s - mu_k) * np.exp(-v_b * speed)


@numba.njit
def bump(speed, mu_s, mu_k, v_b):
    return mu_k + (mu_s - mu_k) / (1.0 + (v_b * speed) ** 2)


@numba.njit
def bump_slope(speed, mu_s, mu_k, v_b):
    return -2.0 * (mu_s - mu_k) * v_b**2 * speed / (1.0 + (v_b * speed) ** 2) ** 2


@numba.njit
def bump_curvature(speed, mu_s, mu_k, v_b):
    u = (v_b * speed) ** 2
    return (mu_s - mu_k) * v_b**2 * (6.0 * u - 2.0) / (1.0 + u) ** 3


SAME = Law("mine", exponential, exponential_slope, exponential_curvature)
BUMP = Law("bump", bump, bump_slope, bump_curvature)

FILE = """
from drillrig_env import Law

def flat(speed, mu_s, mu_k, v_b):
    return mu_k

def nothing(speed, mu_s, mu_k, v_b):
    return 0.0

level = Law("level", flat, nothing, nothing)
"""


@pytest.fixture
def level(tmp_path):
    (tmp_path / "laws.py").write_text(FILE)
    return f"{tmp_path}/laws.py:level"


def test_chapters_law_written_by_hand_gives_the_chapters_answers():
    own, chapters = Friction(20.0, v_b=1.3, law=SAME), Friction(20.0, v_b=1.3)
    speeds = np.array([-2.0, -0.1, 0.01, 1.0, 5.0])
    for name in ("torque", "slope", "curvature"):
        np.testing.assert_allclose(getattr(own, name)(RIG, speeds), getattr(chapters, name)(RIG, speeds), rtol=1e-14)
    assert critical_speed(RIG, own) == pytest.approx(critical_speed(RIG, chapters), rel=1e-12)
    assert fold_speed(RIG, own) == pytest.approx(fold_speed(RIG, chapters), rel=1e-4)  # the line has no step here
    found, expected = hopf_points(RIG, own)[-1], hopf_points(RIG, chapters)[-1]
    assert found.crossing_speed == pytest.approx(expected.crossing_speed, rel=1e-9)
    assert found.lyapunov_coefficient == pytest.approx(expected.lyapunov_coefficient, rel=1e-8)


@pytest.mark.usefixtures("coarser_radau")
@pytest.mark.parametrize(("force", "v_b", "speed"), [(20.0, 1.0, 2.0), (15.0, 4.0, 0.5)])
def test_own_law_is_followed_within_the_tolerance(force, v_b, speed):
    friction = Friction(force, v_b=v_b, law=BUMP)
    fast, slow = (simulate(None, friction, TURNING, speed, 10.0, 0.1, method=method) for method in ("fast", "radau"))
    assert np.abs(fast.state[:, 2:5] - slow.state[:, 2:5]).max() < 1e-6


def test_batch_has_an_own_law_for_all():
    friction = Friction(np.array([10.0, 20.0]), law=BUMP)
    batch = simulate_batch(None, friction, TURNING, 2.0, 3.0)
    for states, one in zip(batch, friction.each(), strict=True):
        np.testing.assert_array_equal(states, simulate(None, one, TURNING, 2.0, 3.0, 0.1).state)


def test_critical_speeds_of_a_batch_are_where_eigenvalues_cross():
    friction = Friction(np.array([10.0, 30.0]), law=BUMP)
    for speed, one in zip(critical_speed(RIG, friction), friction.each(), strict=True):
        behind, ahead = (eigenvalues(RIG, one, speed * k)[0].real for k in (1 - 1e-6, 1 + 1e-6))
        assert behind > 0.0 > ahead
    assert len(stable_speeds(RIG, Friction(10.0, law=BUMP))) == 2


def test_environment_plays_on_a_scenarios_own_law():
    scenario = Scenario(friction=Friction(law=BUMP), spread=0.0, normal_force=(20.0, 20.0), load_step=0.0)
    env = gym.make("DrillRig-v0", scenario=scenario).unwrapped
    env.reset(seed=3, options={"start": "steady", "speed_target": 2.0})
    assert env.core.friction.law == BUMP
    before = env.core.episodes["state"][0, :7].copy()
    env.step(np.zeros(1, dtype=np.float32))
    run = simulate(None, Friction(20.0, law=BUMP), before, float(env.core.episodes["speed_reference"][0]), 0.1, 0.1)
    np.testing.assert_array_equal(env.core.episodes["state"][0, :7], run.state[-1])
    others = pickle.loads(pickle.dumps(env)), copy.deepcopy(env)
    observation, *_ = env.step(np.zeros(1, dtype=np.float32))
    for one in others:
        np.testing.assert_array_equal(one.step(np.zeros(1, dtype=np.float32))[0], observation)


def test_a_running_environment_keeps_its_law():
    env = gym.make("DrillRig-v0").unwrapped
    env.reset(seed=0)
    with pytest.raises(ValueError, match="law of the scenario's friction = 'linear' is not allowed"):
        env.core.change(scenario=Scenario(friction=Friction(law="linear")))


def test_law_survives_copies_and_pickles():
    friction = Friction(12.0, law=BUMP)
    for again in (copy.deepcopy(friction), pickle.loads(pickle.dumps(friction))):
        assert again.law == BUMP
        assert again.torque(RIG, 0.7) == friction.torque(RIG, 0.7)
    assert SAME != BUMP


def test_law_of_a_file_is_kept_by_its_name(level, tmp_path):
    friction = Friction(12.0, law=level)
    assert friction.torque(RIG, 3.0) == pytest.approx(12.0 * RIG.r_1 * friction.mu_k)
    friction.to_toml(tmp_path / "friction.toml")
    assert str(Friction.of(tmp_path / "friction.toml").law) == level
    assert str(pickle.loads(pickle.dumps(friction)).law) == level
    assert Friction(12.0, law=level).law == friction.law
    (tmp_path / "laws.py").write_text(FILE.replace("return mu_k", "return 0.5 * mu_k"))
    assert Friction(12.0, law=level).torque(RIG, 3.0) == pytest.approx(0.5 * friction.torque(RIG, 3.0))


def test_written_law_is_found_from_any_folder(level, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    friction = Friction(12.0, law=level.removeprefix(f"{tmp_path}/"))
    friction.to_toml("friction.toml")
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path / "other")
    assert Friction.from_toml("../friction.toml").law == friction.law


def test_law_that_no_name_leads_to_is_not_written(tmp_path):
    with pytest.raises(ValueError, match=r"law = bump is not allowed; allowed: in a file, a law of one"):
        Friction(law=BUMP).to_toml(tmp_path / "friction.toml")


def test_unknown_names_in_files_are_refused(level, tmp_path):
    with pytest.raises(ValueError, match=r"no Law 'levle'; did you mean level\?"):
        Friction(law=level.replace(":level", ":levle"))
    with pytest.raises(ValueError, match="there is no file"):
        Friction(law=f"{tmp_path}/others.py:level")
    with pytest.raises(ValueError, match=r"law: 3 is not known; allowed: exponential, gaussian, linear, file.py:name"):
        Friction(law=3)


def steep(speed, mu_s, mu_k, v_b):
    return -1.01 * v_b * (mu_s - mu_k) * np.exp(-v_b * speed)


def falls_below_nothing(speed, mu_s, mu_k, v_b):
    return mu_k - 0.4 * speed


def as_fast(speed, mu_s, mu_k, v_b):
    return -0.4


def no_curvature(speed, mu_s, mu_k, v_b):
    return 0.0


def imports_within(speed, mu_s, mu_k, v_b):
    import math

    return math.sqrt(speed)


@pytest.mark.parametrize(
    ("functions", "words"),
    [
        ((exponential, steep, exponential_curvature), ["slope = ", "rad/s", "which differences give"]),
        ((exponential, exponential_slope, no_curvature), ["curvature = 0 ", "which differences give"]),
        ((falls_below_nothing, as_fast, no_curvature), ["the coefficient >= 0"]),
        ((exponential, exponential_slope, 3.0), ["curvature = 3.0 is no function"]),
        ((exponential, exponential_slope, lambda speed: 0.0), ["cannot be compiled: Cannot bind "]),
        ((exponential, exponential_slope, imports_within), ["cannot be compiled: Use of unsupported opcode"]),
        ((exponential, exponential_slope, print), ["is no function"]),
    ],
)
def test_wrong_laws_are_refused(functions, words):
    with pytest.raises(ValueError, match="Law 'wrong'") as caught:
        Law("wrong", *functions)
    for word in words:
        assert word in str(caught.value)
