import json
import signal
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import agents.compared
from agents import compare as module
from agents.compare import compare, main
from agents.compared import Compared, evaluate, read_compared
from agents.policy.run_folder import read_config
from agents.setting import Setting
from agents.training.progress import ShowProgress
from agents.training.settings import Training
from agents.variants import COMPARISONS
from drillrig_env.command_line import Failed
from drillrig_env.evaluation.suites import suite
from drillrig_env.files import owned
from drillrig_env.policy import make_policy
from drillrig_env.seeds import VALIDATION_SEEDS
from tests.agents.conftest import TINY

SCORES = {"mitigated", "calm", "below", "time_to_calm", "cost"}


def setting(name, **changes):
    hyperparams = {**TINY, **changes}
    quick = {"eval_freq": -1, "tensorboard": False, "progress": False}
    return Setting(name, f"words of {name}", Training(n_timesteps=256, hyperparams=hyperparams, **quick))


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A file and its runs; the trainings that are begun are listed."""
    monkeypatch.setattr(module, "BESIDE", {"constant": "action 0, same drive"})
    monkeypatch.setattr(agents.compared, "SUITES", ("default",))
    monkeypatch.setattr(agents.compared, "suite", lambda name, rigs: replace(suite(name, rigs), env={"duration": 12.0}))
    begun, train = [], module.train
    monkeypatch.setattr(module, "train", lambda given: (begun.append(given.run_folder.name), train(given))[1])
    kept = Compared(tmp_path / "docs" / "found.json", tmp_path / "runs", ["one", "two"], "the command")
    return kept, begun


def compared(kept, settings, seeds=1, rigs=4):
    compare(settings, seeds, rigs, kept, kept.lock)
    return read_compared(kept.file)


def test_every_setting_is_trained_scored_and_kept_in_order(place):
    kept, begun = place
    content = compared(kept, [setting("two"), setting("one")], seeds=2)
    assert begun == ["two_0", "one_0", "two_1", "one_1"]
    assert list(content["settings"]) == ["one", "two"]
    assert content["command"] == "the command"
    assert content["provenance"]["versions"]["numpy"]
    for entry in content["settings"].values():
        assert list(entry["runs"]) == ["0", "1"]
        for run in entry["runs"].values():
            assert run["seconds"] >= 0.0
            assert {name: set(scores) for name, scores in run["scores"].items()} == {"default": SCORES}
    assert content["beside"]["policies"]["constant"]["words"] == "action 0, same drive"
    assert content["beside"]["policies"]["constant"]["scores"] == evaluate(make_policy("constant"), "state", 4)


def test_rigs_are_those_of_the_training_side_drawn_as_in_each_suite(monkeypatch):
    faced = []
    monkeypatch.setattr(agents.compared, "run", lambda policy, suite, **_: faced.append(suite))
    monkeypatch.setattr(agents.compared, "score", lambda _: {name: np.ones(2) for name in (*SCORES, "region")})
    found = evaluate(make_policy("constant"), "state", 2)
    assert list(found) == ["default", "wide", "load"]
    for own in faced:
        assert own.definition() == {**suite(own.name, 2).definition(), "first_seed": VALIDATION_SEEDS.start}


def test_what_is_there_is_not_repeated(place):
    kept, begun = place
    first = compared(kept, [setting("one")])
    second = compared(kept, [setting("one")], seeds=2)
    assert begun == ["one_0", "one_1"]
    assert second["settings"]["one"]["runs"]["0"] == first["settings"]["one"]["runs"]["0"]


def test_on_other_rigs_agents_are_scored_again_and_not_trained(place):
    """And in another file: the seeds that have been scored on fewer or more would not be beside each other."""
    kept, begun = place
    compared(kept, [setting("one")], seeds=2)
    before = kept.file.read_bytes()
    with pytest.raises(ValueError, match=r"found\.json is of 4 rigs, not of 5; name another file with --output"):
        compared(kept, [setting("one")], rigs=5)
    assert kept.file.read_bytes() == before
    content = compared(replace(kept, file=kept.file.with_name("five.json")), [setting("one")], rigs=5)
    assert begun == ["one_0", "one_1"]
    assert content["settings"]["one"]["rigs"] == content["beside"]["rigs"] == 5


def test_a_file_of_another_comparison_is_refused_and_left(place):
    kept, begun = place
    compared(replace(kept, comparison="ablations"), [setting("one")])
    before = kept.file.read_bytes()
    other = replace(kept, comparison="newcomer")
    with pytest.raises(ValueError, match=r"is of the comparison 'ablations', and not 'newcomer'; name another file"):
        compared(other, [setting("two")])
    with pytest.raises(ValueError, match="is of the comparison 'ablations'"):
        other.keep_beside(4, "constant", {})
    assert kept.file.read_bytes() == before
    content = json.loads(before)
    del content["comparison"]
    kept.file.write_text(json.dumps(content))
    with pytest.raises(ValueError, match="does not tell which comparison it is of, and not 'newcomer'"):
        compared(other, [setting("two")])
    kept.file.write_text(json.dumps({**content, "command": "python -m agents.compare unknown --seeds 1"}))
    with pytest.raises(ValueError, match="is of the comparison 'unknown', and not 'newcomer'"):
        compared(other, [setting("two")])
    kept.file.write_text(json.dumps({**content, "command": "python -m agents.compare newcomer --seeds 1"}))
    compared(other, [setting("one"), setting("two")])
    assert begun == ["one_0", "two_0"]


@pytest.mark.parametrize("name", ["ablations", "newcomer", "unknown"])
def test_what_is_kept_can_go_on(name):
    Compared(Path("docs", "agents", f"{name}.json"), Path("runs"), [], "", name).check(1000)


def test_policies_that_are_not_there_yet_are_scored(place):
    kept, _ = place
    kept.keep_beside(4, "lqg", {"words": "kept"})
    found = compared(kept, [setting("one")])["beside"]["policies"]
    assert set(found) == {"constant", "lqg"}
    assert found["lqg"] == {"words": "kept"}


def test_a_run_that_does_not_tell_its_time_is_told_of_and_the_others_go_on(place, capsys):
    kept, _ = place
    compared(kept, [setting("one")])
    kept.file.unlink()
    (kept.lock / "one_0" / "progress.json").unlink()
    with pytest.raises(Failed, match="training failed for one, seed 0"):
        compared(kept, [setting("one"), setting("two")])
    assert "one_0 does not tell how long it was trained; remove it" in capsys.readouterr().out
    assert list(kept.read()["settings"]) == ["two"]


ENTRY = {"words": "", "rigs": 4, "runs": {"0": {"seconds": 1.0, "scores": {}}}}


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        ({}, "it has no beside by name"),
        ({"beside": [], "settings": {}}, "it has no beside by name"),
        ({"beside": {}, "settings": []}, "it has no settings by name"),
        ({"beside": {"policies": {}}, "settings": {}}, "what stands beside the settings has no rigs and policies"),
        ({"beside": {"rigs": 4, "policies": []}, "settings": {}}, "what stands beside the settings has no rigs and"),
        ({"beside": {}, "settings": {"one": []}}, "setting 'one' has no rigs and runs"),
        ({"beside": {}, "settings": {"one": {**ENTRY, "rigs": "4"}}}, "setting 'one' has no rigs and runs"),
        ({"beside": {}, "settings": {"one": {**ENTRY, "runs": {"0": 1}}}}, "setting 'one' has no rigs and runs"),
        ({"beside": {}, "settings": {"one": {**ENTRY, "runs": {"x": {}}}}}, "setting 'one' has no scores of seed x"),
    ],
)
def test_a_damaged_file_is_told_before_anything_is_run(content, fault, tmp_path, capsys):
    file = tmp_path / "file.json"
    file.write_text(json.dumps(content))
    with pytest.raises(SystemExit) as end:
        main(f"ablations --runs {tmp_path / 'runs'} --output {file}".split())
    assert end.value.code == 2
    assert f"{file} is damaged: {fault}" in (told := capsys.readouterr().err)
    assert told.endswith("; remove it, and begin again\nhelp: python -m agents.compare --help\n")
    assert not (tmp_path / "runs").exists()


def test_runs_that_cannot_be_written_are_found_before_anything_is_scored(tmp_path, monkeypatch, capsys):
    (tmp_path / "file").touch()
    monkeypatch.setattr(module, "compare", lambda *_: pytest.fail("worked"))
    assert main(f"ablations --output {tmp_path / 'new.json'} --runs {tmp_path / 'file' / 'runs'}".split()) == 1
    assert "cannot be written" in capsys.readouterr().err


def test_a_folder_with_another_setting_is_refused_before_anything_is_trained(place):
    kept, begun = place
    compared(kept, [setting("one")])
    with pytest.raises(ValueError, match=r"one_0 holds a training of another setting; remove it"):
        compared(kept, [setting("two"), setting("one", gamma=0.9)])
    assert begun == ["one_0"]


def test_a_changed_setting_takes_the_place_of_what_it_was(place, tmp_path):
    kept, _ = place
    compared(kept, [setting("one")], seeds=2)
    changed = Compared(kept.file, tmp_path / "others", kept.names, "another command")
    content = compared(changed, [setting("one", gamma=0.9)])
    assert list(content["settings"]["one"]["runs"]) == ["0"]
    assert content["settings"]["one"]["hyperparameters"]["gamma"] == 0.9


def test_a_training_that_was_stopped_goes_on(place, monkeypatch):
    kept, begun = place
    uninterrupted = compared(
        Compared(kept.file.with_name("whole.json"), kept.lock / "whole", ["one"], ""), [setting("one")]
    )
    pressed = []

    def press(self):
        if not pressed:
            pressed.append(True)
            signal.raise_signal(signal.SIGINT)
        return True

    with monkeypatch.context() as patch:
        patch.setattr(ShowProgress, "_on_step", press)
        with pytest.raises(KeyboardInterrupt):
            compared(kept, [setting("one")])
    assert not read_compared(kept.file)["settings"]
    content = compared(kept, [setting("one")])
    assert begun == ["one_0", "one_0"]
    scores = [found["settings"]["one"]["runs"]["0"]["scores"] for found in (uninterrupted, content)]
    assert scores[0] == scores[1]


def test_what_another_process_is_at_is_passed_over(place, capsys):
    kept, begun = place
    with owned(kept.lock / ".taken" / "one_0"):
        content = compared(kept, [setting("one"), setting("two")])
    assert begun == ["two_0"]
    assert list(content["settings"]) == ["two"]
    assert "one_0 is in use by process" in capsys.readouterr().out


def test_two_processes_keep_what_both_have_found(place):
    kept, _ = place
    about = {"words": "", "rigs": 1}
    threads = [
        threading.Thread(target=kept.keep, args=(name, about, seed, {"seconds": 1.0, "scores": {}}))
        for name in kept.names
        for seed in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    content = read_compared(kept.file)
    runs = {name: list(entry["runs"]) for name, entry in content["settings"].items()}
    assert runs == {"one": ["0", "1", "2", "3"], "two": ["0", "1", "2", "3"]}


def test_a_training_that_fails_is_named_and_the_others_are_made(place, monkeypatch):
    kept, _ = place
    train = module.train

    def fails(given):
        if given.run_folder.name == "one_0":
            raise Failed("it was not finite")
        return train(given)

    monkeypatch.setattr(module, "train", fails)
    with pytest.raises(Failed, match="training failed for one, seed 0"):
        compared(kept, [setting("one"), setting("two")])
    assert list(read_compared(kept.file)["settings"]) == ["two"]


@pytest.mark.slow
def test_the_command_trains_what_it_is_told(tmp_path, monkeypatch):
    monkeypatch.setitem(COMPARISONS, "newcomer", lambda: [setting("one"), setting("two")])
    words = (
        f"newcomer --settings two --steps 64 --seeds 1 --rigs 3 --runs {tmp_path / 'r'} --output {tmp_path / 'f.json'}"
    )
    assert main(words.split()) == 0
    content = json.loads((tmp_path / "f.json").read_text())
    assert content["command"] == f"python -m agents.compare {words}"
    assert list(content["settings"]) == ["two"]
    assert read_config(tmp_path / "r" / "two_0")["hyperparameters"]["n_timesteps"] == 64


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("--seeds 0", "--seeds: '0' is not allowed"),
        ("--settings recipy", "'recipy' is not known; did you mean recipe?"),
    ],
)
def test_impossible_words_are_refused(words, told, tmp_path, capsys):
    with pytest.raises(SystemExit):
        main(f"ablations {words} --output {tmp_path / 'file.json'}".split())
    assert told in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
