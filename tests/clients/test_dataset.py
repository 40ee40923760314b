"""Recorded data sets as Minari reads them: bit for bit, with the environment, and whole or not there."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from agents.dataset.__main__ import main
from agents.dataset.recording import ABOUT
from drillrig_env.files import digest
from drillrig_env.seeds import DATASET_SEEDS

pytestmark = pytest.mark.clients
minari = pytest.importorskip("minari", reason="needs the extra clients")
pytest.importorskip("h5py", reason="needs the extra clients")

ROOT = Path(__file__).parents[2]
STEPS = 120
SHORT = ("--env-kwargs", "duration:12.0", "scenario:wide")
NAMES = ("lqg", "ppo", "constant")


def made(folder, *words):
    assert main(["--episodes", "3", "--output", str(folder), *SHORT, *words]) == 0


@pytest.fixture(scope="module")
def sets(tmp_path_factory):
    """The folder of three data sets, and of one of all three policies."""
    folder = tmp_path_factory.mktemp("sets")
    made(folder, "--policies", ",".join(NAMES))
    made(folder, "--policies", ",".join(NAMES), "--mixed")
    return folder


@pytest.fixture(autouse=True)
def _folder(sets, monkeypatch):
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(sets))


def told(data):
    return list(data.storage.get_episode_metadata(data.episode_indices))


@pytest.mark.parametrize("name", NAMES)
def test_environment_plays_the_episodes_again(name):
    data = minari.load_dataset(f"DrillRig-v0/{name}-v0")
    env = data.recover_environment()
    assert (data.total_episodes, data.total_steps) == (3, 3 * STEPS)
    for i, (episode, about) in enumerate(zip(data, told(data), strict=True)):
        assert set(ABOUT) <= set(about)
        assert (about["policy"], about["seed"]) == (name, DATASET_SEEDS.start + i)
        assert episode.truncations.tolist() == [False] * (STEPS - 1) + [True]
        assert not episode.terminations.any()
        observation, info = env.reset(seed=about["seed"])
        np.testing.assert_array_equal(observation, episode.observations[0])
        for k, action in enumerate(episode.actions):
            observation, reward, _, _, info = env.step(action)
            np.testing.assert_array_equal(observation, episode.observations[k + 1])
            assert reward == episode.rewards[k]
            assert info["bit_speed"] == episode.infos["bit_speed"][k + 1]
        assert info["is_success"] == about["mitigated"]
        assert info["normal_force"] == about["normal_force"]


def test_environment_is_rebuilt_where_nothing_else_is_imported(sets):
    data = "minari.load_dataset('DrillRig-v0/lqg-v0')"
    script = f"import minari; print({data}.recover_environment().reset()[0].shape)"
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stdout == "(12,)\n", done.stderr


def test_mixed_data_set_holds_what_the_others_hold():
    mixed = minari.load_dataset("DrillRig-v0/mixed-v0")
    others = [minari.load_dataset(f"DrillRig-v0/{name}-v0") for name in NAMES]
    assert [about["policy"] for about in told(mixed)] == [name for name in NAMES for _ in range(3)]
    for episode, same in zip(mixed, (episode for data in others for episode in data), strict=True):
        np.testing.assert_array_equal(episode.observations, same.observations)
        np.testing.assert_array_equal(episode.actions, same.actions)
        np.testing.assert_array_equal(episode.rewards, same.rewards)


def test_minari_lists_combines_and_scores_them():
    assert set(minari.list_local_datasets()) == {f"DrillRig-v0/{name}-v0" for name in (*NAMES, "mixed")}
    lqg, constant = (minari.load_dataset(f"DrillRig-v0/{name}-v0") for name in ("lqg", "constant"))
    returns = {data.id: np.mean([about["return"] for about in told(data)]) for data in (lqg, constant)}
    assert minari.get_normalized_score(lqg, returns[constant.id]) == pytest.approx(0.0, abs=0.5)
    best = lqg.storage.metadata["ref_max_score"]
    assert minari.get_normalized_score(constant, best) == 1.0
    combined = minari.combine_datasets([lqg, constant], "both-v0")
    assert combined.total_episodes == 6
    minari.delete_dataset("both-v0")


def test_same_seed_gives_the_same_bits_and_another_seed_other_rigs(sets, tmp_path):
    made(tmp_path / "again", "--policies", "lqg", "--threads", "1")
    made(tmp_path / "other", "--policies", "lqg", "--seed", "1")
    file = "DrillRig-v0/lqg-v0/data/main_data.hdf5"
    assert digest(tmp_path / "again" / file) == digest(sets / file)
    assert digest(tmp_path / "other" / file) != digest(sets / file)
    assert (
        told(minari.MinariDataset(tmp_path / "other/DrillRig-v0/lqg-v0/data"))[0]["seed"] == DATASET_SEEDS.start + 10**6
    )


def test_batches_do_not_show(sets, tmp_path, monkeypatch):
    monkeypatch.setattr("agents.dataset.__main__._AT_ONCE", 2)
    made(tmp_path, "--policies", "lqg")
    parts, whole = (minari.MinariDataset(folder / "DrillRig-v0/lqg-v0/data") for folder in (tmp_path, sets))
    assert told(parts) == told(whole)
    for one, same in zip(parts, whole, strict=True):
        np.testing.assert_array_equal(one.observations, same.observations)
        np.testing.assert_array_equal(one.actions, same.actions)


def test_card_tells_scores_and_its_example_runs(sets, capsys):
    card = (sets / "DrillRig-v0/ppo-v0/README.md").read_text(encoding="utf-8")
    assert card.startswith("# DrillRig-v0/ppo-v0\n")
    data = minari.load_dataset("DrillRig-v0/ppo-v0")
    share = np.mean([about["mitigated"] for about in told(data)])
    assert f"| `ppo` | yes | {share:.3f} |" in card
    assert "| `constant` | no | " in card
    (example,) = [part.split("```")[0] for part in card.split("```python\n")[1:]]
    exec(compile(example, "example", "exec"), {})
    assert capsys.readouterr().out.startswith(f"ppo {DATASET_SEEDS.start} ({STEPS + 1}, 12) ")


def test_what_is_there_is_kept_unless_it_may_be_replaced(sets, tmp_path, capsys):
    made(tmp_path, "--policies", "constant")
    file = tmp_path / "DrillRig-v0/constant-v0/data/main_data.hdf5"
    before = digest(file)
    with pytest.raises(SystemExit) as end:
        made(tmp_path, "--policies", "constant", "--seed", "2")
    assert end.value.code == 2
    assert "is there already; remove it, choose another --output, or give --overwrite" in capsys.readouterr().err
    assert digest(file) == before
    made(tmp_path, "--policies", "constant", "--seed", "2", "--overwrite")
    assert digest(file) != before
    assert [path.name for path in (tmp_path / "DrillRig-v0").iterdir()] == ["constant-v0"]


def test_a_policy_that_fails_leaves_nothing(tmp_path, capsys):
    file = tmp_path / "mine.py"
    file.write_text("class Fails:\n    def predict(self, *_, **__):\n        raise RuntimeError('no more')\n")
    words = ["--policies", f"constant,{file}:Fails", "--episodes", "2", "--output", str(tmp_path / "sets"), *SHORT]
    assert main(words) == 1
    assert "error: Fails: RuntimeError: no more" in capsys.readouterr().err
    assert not (tmp_path / "sets").exists()


@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C goes another way there")
def test_ctrl_c_ends_it_soon_and_leaves_nothing(tmp_path):
    output = tmp_path / "sets"
    command = [sys.executable, "-m", "agents.dataset", "--policies", "constant,lqg", "--episodes", "100000"]
    process = subprocess.Popen([*command, "--output", str(output)], cwd=ROOT, stderr=subprocess.PIPE, text=True)
    try:
        while not list(output.glob("*/.*/data/*.hdf5")):
            assert process.poll() is None
            time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=30)
    finally:
        process.kill()
    assert process.returncode == 130
    assert said.endswith("stopped by Ctrl-C; nothing was written; the same command begins anew\n")
    assert "Traceback" not in said
    assert not output.exists()


def test_examples_of_the_page_run(sets, capsys):
    page = (ROOT / "docs" / "datasets.md").read_text(encoding="utf-8")
    loading, cloning = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    exec(compile(loading, "loading", "exec"), {})
    small = cloning.replace("4_000, 1_024, 1_000", "20, 64, 5")
    assert small != cloning
    capsys.readouterr()
    exec(compile(small, "cloning", "exec"), {})
    assert re.fullmatch(r"(?:(?:cloned|lqg|constant): \d\.\d{3} mitigated\n){3}", capsys.readouterr().out)
