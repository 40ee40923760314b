"""What a data set is made of, and the episodes that go into it; on disk, in Minari's format: tests/clients."""

import sys

import gymnasium as gym
import numpy as np
import pytest

from agents.dataset import __main__ as dataset
from agents.dataset.recipe import BLOCK, Recipe, find_players, label_of
from agents.dataset.recording import ABOUT, INFOS, record
from drillrig_env.seeds import DATASET_SEEDS

SHORT = {"duration": 12.0}
STRANGER = """
import numpy as np

class Fails:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        raise RuntimeError("no more")

class Other:
    sensors = ("bit_speed", "speed_target")

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), 1), np.float32), None
"""


@pytest.fixture
def stranger(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(STRANGER)
    return file


@pytest.mark.parametrize("policy", ["lqg", "ppo", "jump_ease", "soft_torque"])
def test_episodes_are_those_of_the_single_environment(policy):
    (player,) = find_players(Recipe(policies=policy, env_kwargs=SHORT))
    first = DATASET_SEEDS.start + 3
    recording = record(player.policy, player.arguments, first, 4)
    env = gym.make(f"drillrig_env:{player.env_id}", **player.env_kwargs)
    assert recording.about["seed"].tolist() == list(range(first, first + 4))
    assert np.abs(recording.actions).max() <= 1.0
    for i in range(4):
        observation, info = env.reset(seed=int(recording.about["seed"][i]))
        total = 0.0
        for k, action in enumerate(recording.actions[i]):
            np.testing.assert_array_equal(observation, recording.observations[i, k])
            assert all(info[name] == recording.infos[name][i, k] for name in INFOS)
            observation, reward, terminated, truncated, info = env.step(action)
            assert reward == recording.rewards[i, k]
            assert (terminated, truncated) == (False, k == len(recording.actions[i]) - 1)
            total += reward
        np.testing.assert_array_equal(observation, recording.observations[i, -1])
        assert info["is_success"] == recording.infos["is_success"][i, -1] == recording.about["mitigated"][i]
        assert info["normal_force"] == recording.about["normal_force"][i]
        assert all(info[name] == recording.about[name][i] for name in ("speed_target", "mu_s", "mu_k", "v_b", "delay"))
        assert recording.about["return"][i] == pytest.approx(total)
    assert {"policy", *recording.about} == set(ABOUT)


def test_an_episode_does_not_depend_on_its_company():
    (player,) = find_players(Recipe(policies="lqg", env_kwargs=SHORT))
    together = record(player.policy, player.arguments, 100, 5)
    alone = record(player.policy, player.arguments, 103, 1)
    np.testing.assert_array_equal(together.observations[3], alone.observations[0])
    np.testing.assert_array_equal(together.actions[3], alone.actions[0])


def test_seeds_of_two_data_sets_have_none_in_common():
    last = Recipe(seed=len(DATASET_SEEDS) // BLOCK - 1, episodes=BLOCK)
    assert Recipe(seed=1).first_seed == Recipe(seed=0).first_seed + BLOCK
    assert last.first_seed + last.episodes - 1 in DATASET_SEEDS
    for seed in (-1, len(DATASET_SEEDS) // BLOCK):
        with pytest.raises(ValueError, match=f"seed = {seed}"):
            Recipe(seed=seed)


def test_a_policy_with_a_drive_brings_it_along():
    own, soft = find_players(Recipe(policies="lqg,soft_torque"))
    assert "drive" not in own.env_kwargs
    assert soft.task.drive == soft.policy.drive
    with pytest.raises(ValueError, match="lqg and soft_torque act through different drives"):
        find_players(Recipe(policies="lqg,soft_torque", mixed=True))
    with pytest.raises(ValueError, match="soft_torque: the environment's drive = "):
        find_players(Recipe(policies="soft_torque", env_kwargs={"drive": (1.0, 1.0, 0.0)}))


def test_policies_are_called_by_the_last_part_of_their_name():
    assert label_of("runs/my.best/ppo_1") == "ppo_1"
    assert label_of("my folder/law.py:My_Law") == "My_Law"
    assert label_of("ppo.2") == "ppo_2"  # as Minari wants names


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--policies", "lqq"], "policy 'lqq' is not known"),
        (["--policies", "lqg,lqg"], "allowed: names of policies, each once"),
        (["--policies", "lqg,"], "allowed: names of policies, each once"),
        (["--policies", "ppo", "--env", "DrillRigSurface-v0"], "ppo: the environment's sensors = "),
        (["--policies", "mine.py:Other"], "mine.py:Other: the environment's sensors = "),
        (["--env", "DrillRig-v1"], "did you mean DrillRig-v0"),
        (["--env-kwargs", "durations:3.0"], "did you mean duration"),
        (["--env-kwargs", "duration:3.05"], "duration = 3.05 s is not allowed"),
        (["--env-kwargs", "duration"], "allowed: NAME:VALUE"),
        (["--env-kwargs", "threads:2"], "give --threads"),
        (["--episodes", "0"], "allowed: whole, >= 1"),
        (["--episode", "3"], "unknown argument --episode; did you mean --episodes?"),
    ],
)
def test_what_is_not_allowed_is_one_sentence(words, message, tmp_path, stranger, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as end:
        dataset.main([*words, "--output", "sets"])
    assert end.value.code == 2
    said = capsys.readouterr().err
    assert message in said
    assert "Traceback" not in said
    assert not (tmp_path / "sets").exists()


def test_without_minari_it_says_what_to_install(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "minari", None)
    with pytest.raises(SystemExit) as end:
        dataset.main(["--policies", "constant", "--output", str(tmp_path / "sets")])
    assert end.value.code == 2
    assert (
        "a data set needs minari and h5py; in a clone of DrillRig: pip install -e '.[clients]'"
        in capsys.readouterr().err
    )
    assert not (tmp_path / "sets").exists()
