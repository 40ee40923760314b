"""What the command line replays: kept runs, and rows of results, which are the evaluation's own episodes."""

import csv
import json

import numpy as np
import pytest

import drillrig_env
from drillrig_env.cli.evaluate import main
from drillrig_env.env.recorded import Recorded
from drillrig_env.room.kept import run_of
from drillrig_env.room.lanes import Lanes
from drillrig_env.room.setting import Setting


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    words = ["constant", "z_torque", "--suite", "load", "degraded", "drift", "--rigs", "3", "--no-pictures"]
    assert main([*words, "--env", "DrillRig-v0", "--output", str(folder)]) == 0
    return folder / "results.csv"


@pytest.mark.slow
def test_a_row_of_results_is_played_as_it_was(results, stock):
    with results.open() as lines:
        rows = list(csv.DictReader(lines))
    for number in (2, 6, 11):
        row, run = rows[number - 1], run_of(f"{results}:{number}")
        assert (run.lanes["A"].policy, run.steps) == (row["policy"], 600)
        lanes = Lanes(Setting(), stock, run)
        lane, low, high, mean = lanes.lanes[0], [], [], []
        while not lanes.at_end:
            lanes.step()
            episode = lane.core.episodes[0]
            low.append(episode["lowest"])
            high.append(episode["highest"])
            mean.append(episode["average"])
        index = (max(high[-100:]) - min(low[-100:])) / (2 * np.mean(mean[-100:]))
        assert f"{index:.6g}" == row["ssi"]
        assert f"{max(high) / lanes.given.values['speed_target']:.6g}" == row["peak_speed"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("place", "sentence"),
    [
        ("{csv}:0", "has no row 0"),
        ("{csv}:99", "has no row 99"),
        ("{csv}:13", "suite 'drift' is not played here"),
        ("{csv}", "says no row"),
        ("{csv}.json", "there is no file"),
        ("/nowhere/results.csv:1", "there is no file"),
        ("{folder}/results.json", "not a recorded run"),
        ("{folder}", "not a recorded run"),
    ],
)
def test_what_cannot_be_replayed_is_said_in_a_sentence(results, place, sentence):
    with pytest.raises((ValueError, FileNotFoundError)) as refused:
        run_of(place.format(csv=results, folder=results.parent))
    assert sentence in str(refused.value)


@pytest.fixture
def content(stock):
    lanes = Lanes(Setting(b="constant"), stock)
    for _ in range(3):
        lanes.step()
    return lanes.as_recorded().as_json()


def test_a_run_reads_back_what_was_written(content, tmp_path):
    Recorded.of(content).write(tmp_path / "run.json")
    assert json.loads((tmp_path / "run.json").read_text()) == json.loads(json.dumps(content))
    assert Recorded.read(tmp_path / "run.json").as_json() == content
    assert drillrig_env.__version__


@pytest.mark.parametrize(
    ("path", "value", "sentence"),
    [
        ("format", "other", "its format is not 'drillrig-run'"),
        ("version", 2, "version = 2 is not allowed; allowed: 1"),
        ("law", "my_law.py:fall", "law = 'my_law.py:fall' is not known"),
        ("rig", "/etc/passwd", "rig and setting must be tables"),
        ("rig.J_1", -1.0, "J_1 = -1.0 kg m^2"),
        ("rig.J_4", 1.0, "unknown key J_4"),
        ("reset.seed", -1, "a seed and a start are wanted"),
        ("reset.seed", "x", "run:"),
        ("reset.options", {"start": "given"}, "a seed and a start are wanted"),
        ("course.time", [1.0], "Course: time 0 = 1.0 s"),
        ("course.mu_s", [0.1], "mu_s at 0 s"),
        ("course.v_b", "a.csv", "Course: v_b"),
        ("lanes", {}, "there is no lane in it"),
        ("lanes.A.actions", [0.1, 2.0], "actions must be"),
        ("lanes.A.actions", [float("nan")], "actions must be"),
        ("lanes.A.actions", [[0.1]], "actions must be"),
        ("lanes.A.sensors", ["eyes"], "unknown channel 'eyes'"),
        ("lanes.A.drive", {"k_p": 1.0}, "k_i is missing"),
    ],
)
def test_a_run_that_is_none_is_refused_by_name(content, path, value, sentence):
    *parts, last = path.split(".")
    table = content
    for part in parts:
        table = table[part]
    table[last] = value
    with pytest.raises(ValueError, match="run: ") as refused:
        Recorded.of(content)
    assert sentence in str(refused.value)


@pytest.mark.parametrize("missing", ["rig", "law", "reset", "course", "lanes"])
def test_a_run_that_lacks_something_is_refused_by_name(content, missing):
    del content[missing]
    with pytest.raises(ValueError, match=f"the entry '{missing}' is missing"):
        Recorded.of(content)


@pytest.mark.slow
def test_an_evaluation_plays_the_scenario_of_a_run_bit_for_bit(stock, tmp_path):
    lanes = Lanes(Setting(a="constant", b="z_torque", sensors="surface", seed=9), stock)
    for step in range(150):
        if step == 20:
            lanes.given.set({"normal_force": 22.0})
        lanes.step()
    lanes.as_recorded().write(tmp_path / "run.json")
    words = ["constant", "z_torque", "--env", "DrillRigSurface-v0", "--run", str(tmp_path / "run.json")]
    assert main([*words, "--no-pictures", "--output", str(tmp_path / "results")]) == 0
    with (tmp_path / "results" / "results.csv").open() as lines:
        rows = {row["policy"]: row for row in csv.DictReader(lines)}
    for lane, policy in zip(lanes.lanes, ("constant", "z_torque"), strict=True):
        verdict = lane.verdict.now(2.5)
        assert rows[policy]["ssi"] == f"{verdict.index:.6g}"
        assert rows[policy]["normal_force"] == "22"


def test_a_run_that_cannot_be_evaluated_is_said_in_a_sentence(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["constant", "--run", str(tmp_path / "none.json"), "--output", str(tmp_path / "results")])
    assert ended.value.code == 2
    assert "there is no file" in capsys.readouterr().err


@pytest.mark.slow
def test_a_run_too_short_to_be_judged_is_refused(stock, tmp_path, capsys):
    lanes = Lanes(Setting(a="constant"), stock)
    lanes.step()
    lanes.as_recorded().write(tmp_path / "run.json")
    with pytest.raises(SystemExit) as ended:
        main(["constant", "--run", str(tmp_path / "run.json"), "--output", str(tmp_path / "results")])
    assert ended.value.code == 2
    assert "run.json: a run of 0.1 s is not judged; allowed: 10 s or more" in capsys.readouterr().err
