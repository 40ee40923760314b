import json
from dataclasses import replace

import numpy as np
import pytest

from baselines import BASELINES
from baselines.for_fleets import OF_FLEETS
from baselines.tries import Tries
from baselines.tune import _Shown, keep, main, measure, search, tuning_suite
from baselines.tuned import RECORD
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.seeds import EVALUATION_SEEDS, TUNING_FLEETS, TUNING_SEEDS

ENTRIES = json.loads(RECORD.read_text(encoding="utf-8"))


def test_all_tuned_values_are_on_record_and_from_training_seeds():
    kept = {(entry["controller"], sensors) for entry in ENTRIES for sensors in entry["sensors"]}
    tuned = BASELINES | OF_FLEETS
    assert kept == {(name, sensors) for name, kind in tuned.items() for sensors in kind.tuned_values}
    for entry in ENTRIES:
        assert entry["first_seed"] in TUNING_SEEDS
        assert entry["first_seed"] + entry["rigs"] + entry["fresh_rigs"] - 1 in TUNING_SEEDS


def brief(name, rigs, first=TUNING_SEEDS.start):
    return replace(tuning_suite(name, rigs, first), env={"duration": 15.0})


def test_search_is_repeatable_and_better_than_a_bad_gain():
    suites = [brief("default", 12)]
    found = search("soft_torque", ["state"], suites, budget=24)
    assert found == search("soft_torque", ["state"], suites, budget=24)
    worst = {"proportional": 0.6, "integral": 0.5}
    best, bad = (measure("soft_torque", values, "state", suites[0]) for values in (found, worst))
    assert best["mitigated"] > bad["mitigated"]


def test_tuning_suite_keeps_off_the_seeds_of_the_evaluation():
    assert tuning_suite("load", 10).first_seed == TUNING_SEEDS.start
    with pytest.raises(ValueError, match="tune: first seed = 999999999 is not allowed"):
        tuning_suite("default", 10, EVALUATION_SEEDS.start - 1)


def test_an_entry_takes_the_place_of_an_earlier_one_for_the_same_sensors(tmp_path):
    record = tmp_path / "tuned.json"
    keep(record, {"controller": "a", "sensors": ["state"], "values": {"gain": 1.0}})
    keep(record, {"controller": "a", "sensors": ["surface"], "values": {"gain": 2.0}})
    keep(record, {"controller": "a", "sensors": ["state"], "values": {"gain": 3.0}})
    gains = [entry["values"]["gain"] for entry in json.loads(record.read_text(encoding="utf-8"))]
    np.testing.assert_array_equal(gains, [2.0, 3.0])


def test_a_controller_without_gains_is_refused():
    with pytest.raises(ValueError, match=r"'constant' has no gains to tune; .*allowed: .*z_torque"):
        search("constant", ["state"], [tuning_suite("default", 2)], budget=10)


FEW = ["soft_torque", "--suites", "default", "--rigs", "6", "--check", "6", "--budget", "24"]


def record(path):
    return [{**entry, "date": None} for entry in json.loads(path.read_text(encoding="utf-8"))]


def test_a_stopped_search_goes_on_to_the_same_end_bit_for_bit(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("baselines.tune.tuning_suite", brief)
    assert main(FEW) == 0
    uncut = record(tmp_path / "tuned.json")
    assert "tuned.tries.json" not in [path.name for path in tmp_path.iterdir()]
    told = capsys.readouterr().out
    assert "soft_torque: 20 of about 24 tries" in told
    assert str(tmp_path / "tuned.json") in told
    measured = []

    def stopped(*given):
        if len(measured) == 15:
            raise KeyboardInterrupt
        measured.append(given)
        return measure(*given)

    with monkeypatch.context() as cut:
        cut.setattr("baselines.tune.measure", stopped)
        assert main([*FEW, "--output", "cut.json"]) == 130
    assert "cut.tries.json keeps 15 of about 24 tries; to go on, add --resume" in capsys.readouterr().err
    assert not (tmp_path / "cut.json").exists()
    measured.clear()
    monkeypatch.setattr("baselines.tune.measure", lambda *given: measured.append(given) or measure(*given))
    assert main([*FEW, "--output", "cut.json", "--resume"]) == 0
    assert record(tmp_path / "cut.json") == uncut
    assert len(measured) < 24


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--budget", "0"], "argument --budget: '0' is not allowed; allowed: whole, >= 1"),
        (["--rigs", "0"], "argument --rigs: '0' is not allowed"),
        (["--first-seed", "0"], "--first-seed: '0' is not allowed; allowed: whole, >= 500000000 and <= 599999999"),
        (["--first-seed", "many"], "argument --first-seed: 'many' is not allowed; allowed: whole"),
        (["--first-seed", "599999999"], "first seed = 599999999 is not allowed; allowed: 500000000 to "),
        (["--resume"], "there is no search to go on with: tuned.tries.json is missing"),
        (["--output", "mine.json"], "mine.json is no record of tuning"),
        (["--budge", "3"], "did you mean --budget?"),
    ],
)
def test_mistakes_are_explained_before_any_work(arguments, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("baselines.tune.measure", lambda *_: pytest.fail("tried"))
    (tmp_path / "mine.json").write_text("{")
    with pytest.raises(SystemExit) as end:
        main([*FEW, *arguments])
    assert end.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith("python -m baselines.tune: error: ")
    assert message in said


def test_a_record_that_cannot_be_written_is_known_before_any_work(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("baselines.tune.measure", lambda *_: pytest.fail("tried"))
    (tmp_path / "note").touch()
    assert main([*FEW, "--output", "note/mine.json"]) == 1
    assert "note" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["note"]


def test_a_search_does_not_run_over_another_that_was_stopped(tmp_path):
    path = tmp_path / "tuned.tries.json"
    tries = Tries(path, {"seed": 0})
    assert tries.worth([1.0, 0.1], lambda: 0.5) == 0.5
    with pytest.raises(ValueError, match=r"tuned\.tries\.json holds a search that was stopped; go on with --resume"):
        Tries(path, {"seed": 0})
    with pytest.raises(ValueError, match="of a search with seed = 0, not 1"):
        Tries(path, {"seed": 1}, resume=True)
    again = Tries(path, {"seed": 0}, resume=True)
    assert again.worth([1.0, 0.1], lambda: pytest.fail("run again")) == 0.5
    with pytest.raises(ValueError, match="another version: try 1 differs"):
        Tries(path, {"seed": 0}, resume=True).worth([2.0, 0.1], lambda: 0.0)
    path.write_text(path.read_text()[:20])
    with pytest.raises(ValueError, match=r"tuned\.tries\.json is damaged: .*; remove it to begin again"):
        Tries(path, {"seed": 0}, resume=True)


def test_a_search_without_tries_is_refused():
    with pytest.raises(ValueError, match="budget = 0 tries is not allowed; allowed: >= 1"):
        search("soft_torque", ["state"], [tuning_suite("default", 2)], budget=0)


def test_without_a_terminal_every_twentieth_try_is_a_line_and_no_bar_is_drawn(capsys):
    with _Shown("lqg", 45) as shown:
        assert not any(task.visible for task in shown.bar.tasks)
        for tried in range(45):
            shown.tell(0.01 * tried)
    lines = capsys.readouterr().out.splitlines()
    assert [line for line in lines if line] == [
        "lqg: 20 of about 45 tries, best 0.1900",
        "lqg: 40 of about 45 tries, best 0.3900",
    ]
    assert shown.bar.tasks[0].completed == 45


def test_fleets_to_tune_on_are_apart_from_those_that_are_judged():
    for first in (TUNING_SEEDS.start, TUNING_SEEDS.start + 24):
        assert tuning_suite("unknown", 4, first).scenario.rigs.seed in TUNING_FLEETS
    one, other = (tuning_suite("unknown", 4, TUNING_SEEDS.start + k).scenario.rigs.members().rigs for k in (0, 24))
    assert not set(one) & set(other)


@pytest.mark.parametrize("name", OF_FLEETS)
def test_what_was_tuned_on_a_fleet_acts_by_those_values(name):
    entry = next(entry for entry in ENTRIES if entry["controller"] == name)
    (suite,) = entry["suites"]
    assert suite == ("drift" if name.endswith("_drift") else "unknown")
    given, found = (
        score(run(policy, tuning_suite(suite, 2), sensors="surface"))["cost"] for policy in _both(name, entry)
    )
    assert (given == found).all()
    low, high = zip(*OF_FLEETS[name].tuned.values(), strict=True)
    assert all(a <= value <= b for a, value, b in zip(low, entry["values"].values(), high, strict=True))


def _both(name, entry):
    return OF_FLEETS[name]("surface", **entry["values"]), OF_FLEETS[name]("surface")
