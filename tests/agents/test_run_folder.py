"""Run folders: made by one process each, and read without trusting what they hold."""

import io
import json
import shutil
import warnings
import zipfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import torch

from agents.policy.run_folder import (
    CONFIG,
    MODEL,
    SEEDS,
    TRAINED,
    is_finished,
    load_policy,
    new_run,
    read_config,
    read_seeds,
    shipped,
)
from agents.policy.weights import saved_steps


@pytest.fixture
def run(tmp_path):
    """A copy of a shipped agent's folder."""
    shutil.copytree(TRAINED / "ppo", tmp_path / "ppo")
    return tmp_path / "ppo"


def rewritten(path, **members):
    """Put other content into members of a model.zip."""
    with zipfile.ZipFile(path) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in {**content, **{f"{key}.pth": value for key, value in members.items()}}.items():
            archive.writestr(name, data)


def test_run_folders_that_are_made_at_once_are_all_different(tmp_path):
    with ThreadPoolExecutor(16) as pool:
        folders = list(pool.map(lambda _: new_run(tmp_path / "runs", "ppo"), range(80)))
    assert len(set(folders)) == 80
    assert {path.name for path in folders} == {f"ppo_{number}" for number in range(1, 81)}


def test_a_folder_that_is_there_is_not_taken(tmp_path):
    with pytest.raises(ValueError, match="is there already; choose another"):
        new_run(tmp_path, "ppo", tmp_path)


@pytest.mark.parametrize("name", shipped())
def test_a_shipped_agent_loads_without_a_warning_and_is_finished(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        agent = load_policy(TRAINED / name)
    assert agent.model.num_timesteps == saved_steps(TRAINED / name / MODEL)
    assert is_finished(TRAINED / name)


def test_the_model_is_the_one_that_was_saved(run):
    """As Stable-Baselines3 itself loads it, which runs what the file holds."""
    from stable_baselines3 import PPO

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        saved = PPO.load(run / MODEL, device="cpu")
    observations = np.random.default_rng(0).normal(size=(50, *saved.observation_space.shape)).astype(np.float32)
    expected = saved.predict(observations, deterministic=True)[0]
    np.testing.assert_array_equal(load_policy(run).model.predict(observations, deterministic=True)[0], expected)


class Trap:
    """Writes a file when it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return (open, (str(self.path), "w"))


def test_a_model_from_somebody_else_executes_nothing(run, tmp_path):
    import base64
    import pickle

    sprung = tmp_path / "sprung"
    with zipfile.ZipFile(run / MODEL) as archive:
        data = json.loads(archive.read("data"))
        content = {name: archive.read(name) for name in archive.namelist()}
    trap = base64.b64encode(pickle.dumps(Trap(sprung))).decode()
    data["policy_class"] = {":type:": "trap", ":serialized:": trap}
    with zipfile.ZipFile(run / MODEL, "w") as archive:
        for name, value in {**content, "data": json.dumps(data).encode()}.items():
            archive.writestr(name, value)
    assert load_policy(run).model.num_timesteps > 0
    assert not sprung.exists()
    weights = io.BytesIO()
    torch.save({"action_net.bias": Trap(sprung)}, weights)
    rewritten(run / MODEL, policy=weights.getvalue())
    with pytest.raises(ValueError, match=r"model\.zip holds more than weights and is not read"):
        load_policy(run)
    assert not sprung.exists()


def test_a_damaged_model_is_named_with_what_to_do(run):
    whole = (run / MODEL).read_bytes()
    for damaged in (whole[: len(whole) // 2], b"", b"no archive"):
        (run / MODEL).write_bytes(damaged)
        with pytest.raises(ValueError, match=r"model\.zip is damaged: .*; take another model"):
            load_policy(run)
        assert not is_finished(run)


def test_a_model_of_another_network_is_named(run):
    shutil.copyfile(TRAINED / "ppo_surface_soft" / MODEL, run / MODEL)
    with pytest.raises(ValueError, match=r"model\.zip does not fit the network of its config\.json"):
        load_policy(run)


def test_a_damaged_config_is_named_with_what_to_do(run):
    config = read_config(run)
    (run / CONFIG).write_text(json.dumps(config)[:100])
    with pytest.raises(ValueError, match=r"config\.json is damaged: it is not JSON .*; write it again"):
        load_policy(run)
    del config["env_kwargs"], config["seed"]
    (run / CONFIG).write_text(json.dumps(config))
    with pytest.raises(ValueError, match=r"config\.json is damaged: it does not tell env_kwargs, seed; write it again"):
        load_policy(run)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"algorithm": 7}, r"is damaged: algorithm = 7; allowed: text; write it again"),
        ({"env_kwargs": ["delay"]}, r"is damaged: env_kwargs = \['delay'\]; allowed: values by name"),
        ({"hyperparameters": []}, r"is damaged: hyperparameters = \[\]; allowed: values by name"),
        ({"seed": "first"}, r"is damaged: seed = 'first'; allowed: a whole number"),
        ({"algorithm": "sacc"}, r"describes no model: algorithm 'sacc' is not known; did you mean sac\?"),
        ({"env_id": "DrillRig-v8"}, r"describes no model: environment 'DrillRig-v8' is not known; did you mean"),
        ({"env_kwargs": {"sensors": "stat"}}, r"describes no model: sensors = 'stat' is not known; did you mean state"),
        ({"hyperparameters": {"frame_stack": 0}}, r"describes no model: ppo: frame_stack = 0 is not allowed"),
        ({"hyperparameters": {"n_envs": None}}, r"describes no model: ppo: n_envs = None"),
        ({"hyperparameters": {"gama": 0.9}}, r"describes no model: ppo: unknown hyperparameter 'gama'; did you mean"),
        ({"hyperparameters": {"policy": "CnnPolicy"}}, r"describes no model: .* only with images"),
    ],
    ids=str,
)
def test_a_config_that_was_edited_wrongly_is_named_with_what_of_it(run, changes, words):
    config = read_config(run)
    edited = config | changes
    if isinstance(changes.get("hyperparameters"), dict):
        edited["hyperparameters"] = config["hyperparameters"] | changes["hyperparameters"]
    (run / CONFIG).write_text(json.dumps(edited))
    with pytest.raises(ValueError, match=rf"config\.json {words}"):
        load_policy(run)


def test_damaged_seeds_are_named_with_what_to_do(run):
    (run / SEEDS).write_text("{")
    with pytest.raises(ValueError, match=r"seeds\.json is damaged: .*; ship the agent again"):
        read_seeds(run)
