"""Tuning: what is looked through, what a try is worth, and a study that goes on after any stop."""

import itertools
import sys

import pytest
import yaml
from stable_baselines3.common.callbacks import BaseCallback

from agents.training.hyperparameters import HYPERPARAMETER_FILES, hyperparameters
from agents.training.settings import Training
from agents.training.train import try_out
from agents.tuning import objective, search, study, trial
from agents.tuning.objective import OBJECTIVES, validation_suite
from agents.tuning.space import Dimension, Space, seed_of
from agents.tuning.study import Study
from agents.tuning.trial import Question
from drillrig_env.command_line import Failed
from drillrig_env.engine import Local
from drillrig_env.seeds import EVALUATION_SEEDS, TRAINING_SEEDS, TUNING_SEEDS, VALIDATION_SEEDS
from tests.agents.tiny import PPO

pytest.importorskip("optuna")
SEARCH = {"gamma": {"low": 0.9, "high": 0.99}, "n_epochs": {"choices": [1, 2]}, "n_steps": {"low": 8, "high": 16}}


def conf(tmp_path, found=SEARCH, **changes):
    path = tmp_path / "conf.yml"
    table = {**PPO, "policy": "MlpPolicy", "n_timesteps": 1000, "env_kwargs": {"duration": 20.0}, **changes}
    path.write_text(yaml.safe_dump({"DrillRig-v0": {**table, "search": found}}))
    return path


def question(tmp_path, **changes):
    return Question.of(Training(conf_file=conf(tmp_path)), rigs=4, **changes)


@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_the_projects_own_files_say_what_to_look_through(algorithm):
    space = Space.of(algorithm, "DrillRig-v0")
    assert len(space.dimensions) >= 5
    assert [one.name for one in space.dimensions] == list(space.own())
    assert f"lin_{float(space.table['learning_rate'][4:]):.3g}" == space.changes(space.own())["learning_rate"]
    assert "search" not in hyperparameters(algorithm, "DrillRig-v0")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "says for DrillRig-v0 nowhere what to look through"),
        ({"gamma": 0.9}, "gamma = 0.9 is not allowed; allowed: choices, or low and high"),
        ({"gamma": {"low": 0.9}}, "allowed: numbers low and high"),
        ({"gamma": {"low": 0.9, "high": 0.8}}, "allowed: low < high"),
        ({"gamma": {"low": 0.0, "high": 0.8, "log": True}}, "allowed: low < high, and low > 0 with log"),
        ({"gamma": {"low": 0.9, "high": 1.5}}, "gamma = 1.5 is not allowed"),
        ({"gama": {"low": 0.9, "high": 0.99}}, "unknown hyperparameter 'gama'"),
        (
            {"n_epochs": {"choices": [2, 3]}},
            r"n_epochs = 1 is not allowed; allowed: the file's own value among \(2, 3\)",
        ),
        ({"n_steps": {"low": 20, "high": 30}}, "n_steps = 16 is not allowed; allowed: the file's own value among"),
        ({"n_epochs": {"choices": [1]}}, "allowed: choices: a list of two or more, alone"),
        ({"learning_rate": {"low": 0.1, "high": 0.2, "as": "lin_{x}"}}, "a text with a place for the number"),
    ],
)
def test_what_cannot_be_looked_through_is_refused(given, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        Space.of("ppo", "DrillRig-v0", conf(tmp_path, given))


def test_what_is_drawn_becomes_hyperparameters():
    rate = Dimension.of("learning_rate", {"low": 1e-4, "high": 1e-2, "log": True, "as": "lin_{:.3g}"})
    assert (rate.high, rate.value(0.00123456)) == (0.01, "lin_0.00123")
    assert Dimension.of("n", {"low": 2, "high": 9}).value(7) == 7
    rounds = Dimension.of("imitation.rounds", {"low": 2, "high": 9})
    space = Space((rate, rounds), {})
    found = space.changes({"learning_rate": 0.002, "imitation.rounds": 3, "gamma": 0.9})
    assert found == {"learning_rate": "lin_0.002", "imitation.rounds": 3}
    assert (rate.drawn("lin_0.002"), rate.drawn("lin_1.0"), rate.drawn("cos_0.002"), rate.drawn(None)) == (
        0.002,
        *3 * [None],
    )
    assert (rounds.drawn(5), rounds.drawn(2.5), Dimension.of("n", {"choices": [64, 128]}).drawn(64)) == (5, None, 64)
    assert seed_of({"a": 1}, 5) == seed_of({"a": 1}, 0) + 5 != seed_of({"a": 2}, 0) + 5


def test_what_is_drawn_for_a_part_of_what_is_imitated_leaves_the_rest():
    file = HYPERPARAMETER_FILES / "unknown" / "ppo_asymmetric.yml"
    training = Training("ppo_asymmetric", "DrillRigUnknown-v0", conf_file=file)
    one = Question.of(training, rigs=4)
    drawn, own = one.chosen({"imitation.log_std": -2.0}), one.base["hyperparameters"]
    assert drawn == {**own, "imitation": {**own["imitation"], "log_std": -2.0}}
    assert own["imitation"]["log_std"] != -2.0


def test_tries_are_judged_on_rigs_of_their_own():
    chosen = validation_suite("default", 500)
    rigs = range(chosen.first_seed, chosen.first_seed + chosen.rigs)
    assert rigs.start in VALIDATION_SEEDS
    assert rigs[-1] in VALIDATION_SEEDS
    for others in (TRAINING_SEEDS, TUNING_SEEDS, EVALUATION_SEEDS, range(VALIDATION_SEEDS.start, 10_000)):
        assert rigs.start not in others
    assert validation_suite("unknown", 4).scenario.rigs.seed != validation_suite("default", 4).scenario.rigs
    with pytest.raises(ValueError, match="its rigs are all judged on"):
        validation_suite("chapter", 4)


def test_objectives_and_suites_are_known_by_name(tmp_path):
    for changes, message in (({"objective": "worht"}, "did you mean"), ({"suite": "defualt"}, "did you mean")):
        with pytest.raises(ValueError, match=message):
            question(tmp_path, **changes)
    assert set(OBJECTIVES) == {"worth", "mitigated", "calm", "reward", "time_to_calm"}


def test_tries_are_judged_on_the_environments_own_rigs_unless_told(tmp_path):
    assert question(tmp_path).suite == "default"
    file = HYPERPARAMETER_FILES / "unknown" / "ppo_asymmetric.yml"
    assert Question.of(Training("ppo_asymmetric", "DrillRigUnknown-v0", conf_file=file), rigs=1).suite == "unknown"


def test_files_with_something_to_look_through_are_named():
    with pytest.raises(ValueError, match=r"nowhere .*, as in .*unknown.ppo_asymmetric\.yml \(--conf-file\)$"):
        Space.of("ppo_asymmetric", "DrillRigUnknown-v0")
    with pytest.raises(ValueError, match=r"ranges under `search`$"):
        Space.of("ppo_asymmetric", "DrillRigDrift-v0")


class Pretends:
    """In the place of a training: worth follows from gamma; a try comes to its end in ten looks."""

    def __init__(self, fails=False, stop_at=None):
        self.fails, self.asked, self.stop_at = fails, [], stop_at

    def __call__(self, asked, drawn, told):
        self.asked.append(drawn)
        if self.fails:
            raise ValueError("never")
        for look in range(1, 11):
            if self.stop_at == (len(self.asked), look):
                raise KeyboardInterrupt
            if told(100 * look, drawn["gamma"] + 0.001 * look):
                return


def searched(folder, asked, pretends, monkeypatch, steps=4000, **changes):
    monkeypatch.setattr(Question, "ask", lambda self, drawn, told: pretends(self, drawn, told))
    monkeypatch.setattr("agents.tuning.picture.draw_study", lambda *_: None)  # it takes its time
    said = []
    return search.search(folder, asked, steps, None, changes.get("engine", Local()), said.append), said


def test_a_study_ends_with_its_budget_and_writes_what_it_found(tmp_path, monkeypatch):
    asked = question(tmp_path)
    found, said = searched(tmp_path / "study", asked, Pretends(), monkeypatch)
    assert found.spent >= 4000 > found.spent - 1000
    assert any("ended early" in line for line in said)
    best = max((one for one in found.done if found.is_full(one)), key=lambda one: one.params["gamma"])
    assert found.best_first()[0].number == best.number
    content = yaml.safe_load((tmp_path / "study" / "best.yml").read_text())["DrillRig-v0"]
    assert content["gamma"] == pytest.approx(best.params["gamma"], rel=1e-2)
    again = hyperparameters("ppo", "DrillRig-v0", file=tmp_path / "study" / "best.yml")
    assert again["n_epochs"] == best.params["n_epochs"]
    lines = (tmp_path / "study" / "tries.md").read_text().splitlines()
    assert str(seed_of(best.params, 0)) in lines[2]
    assert len(lines) <= 12


def test_no_try_is_ended_before_its_actor_learns(tmp_path):
    firsts = [Question.of(Training(algorithm=one)).first_look for one in ("ppo", "sac")]
    assert firsts == [40 * 256 * 128 + 600_000, 750 * 64 + 8000]
    assert question(tmp_path).first_look == 100
    held = Question.of(Training(conf_file=conf(tmp_path, critic_iterations=100)), rigs=4)
    assert held.first_look == held.steps


def test_a_study_begins_with_what_the_file_has(tmp_path, monkeypatch):
    pretends = Pretends()
    asked = Question.of(Training(conf_file=conf(tmp_path, gamma=0.95, n_epochs=2, n_steps=9)), rigs=4)
    searched(tmp_path / "study", asked, pretends, monkeypatch, steps=2000)
    assert {name: pretends.asked[0][name] for name in SEARCH} == {"gamma": 0.95, "n_epochs": 2, "n_steps": 9}


def test_a_study_that_was_cut_goes_on_with_the_try_that_was_cut(tmp_path, monkeypatch):
    asked, pretends = question(tmp_path), Pretends(stop_at=(3, 1))
    with pytest.raises(KeyboardInterrupt) as stop:
        searched(tmp_path / "study", asked, pretends, monkeypatch)
    assert "the same command goes on" in stop.value.__notes__[0]
    cut, more = pretends.asked[-1], Pretends()
    found, said = searched(tmp_path / "study", asked, more, monkeypatch)
    assert said[0] == "1 try that was cut is begun again"
    assert more.asked[0] == cut
    assert all(drawn not in pretends.asked for drawn in more.asked[1:])
    assert len(found.done) == len(pretends.asked) - 1 + len(more.asked)
    other = question(tmp_path, objective="calm")
    with pytest.raises(ValueError, match="is a study of another objective"):
        searched(tmp_path / "study", other, Pretends(), monkeypatch)


def test_tries_that_only_fail_end_the_search(tmp_path, monkeypatch):
    with pytest.raises(Failed, match="5 tries failed one after another; the last: never"):
        searched(tmp_path / "study", question(tmp_path), Pretends(fails=True), monkeypatch)


def test_a_budget_below_one_try_is_refused(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match="a budget of 999 steps is less than one try; allowed: >= 1,000 steps"):
        searched(tmp_path / "study", question(tmp_path), Pretends(), monkeypatch, steps=999)
    assert not (tmp_path / "study").exists()


def test_a_try_that_is_stopped_while_it_begins_says_nothing_of_its_own_folder(tmp_path):
    class Stop(BaseCallback):
        def _on_training_start(self):
            raise KeyboardInterrupt

        def _on_step(self):
            return True

    with pytest.raises(KeyboardInterrupt) as stop:
        try_out(question(tmp_path).config({}), tmp_path, [Stop()], 1)
    assert not getattr(stop.value, "__notes__", ())


def test_it_is_told_how_far_a_search_is(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("agents.tuning.shown._SECONDS", -1.0)
    searched(tmp_path / "study", question(tmp_path), Pretends(), monkeypatch, steps=2000)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "try 0 begins; 0% of the budget is spent"
    assert lines[5].startswith("try 0 is worth 0.")
    assert lines[5].endswith("after 500 of 1,000 steps; 25% of the budget is spent")


def test_a_try_that_was_to_be_begun_again_when_there_was_enough_has_ended(tmp_path, monkeypatch):
    """Its worker was lost, and then nobody tells of it any more; its steps were taken."""

    class Elsewhere(Local):
        here = False

    def tune(engine, asker, tries):
        first, lost, _ = (asker.ask()[0] for _ in range(3))
        asker.told(lost, 1200, 0.3)
        asker.told(first, 2800, 0.5)
        asker.ended(first)
        assert asker.enough()

    monkeypatch.setattr(search, "is_ray", lambda engine: True)
    monkeypatch.setattr(search, "tune", tune)
    asked = question(tmp_path)
    found = search.search(tmp_path / "study", asked, 4000, None, Elsewhere(), lambda line: None)
    assert found.spent == 4000
    assert len(found.done) == 2
    assert Study(tmp_path / "study", asked).take_up_cut() == 1


def test_several_at_a_time_are_for_ray(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match="--on ray does tries side by side"):
        searched(tmp_path / "study", question(tmp_path), Pretends(), monkeypatch, engine=Local(2))


def test_the_time_is_a_budget_too(tmp_path, monkeypatch):
    clock = itertools.count(0.0, 600.0)
    monkeypatch.setattr("agents.tuning.picture.draw_study", lambda *_: None)
    monkeypatch.setattr(search.time, "monotonic", lambda: next(clock))
    monkeypatch.setattr(Question, "ask", lambda self, drawn, told: Pretends()(self, drawn, told))
    found = search.search(tmp_path / "study", question(tmp_path), 10**9, 1.0, Local(), lambda line: None)
    assert 1 <= len(found.done) < 5


def test_without_optuna_it_is_said_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "optuna", None)
    with pytest.raises(ImportError, match=r"tuning needs optuna; in a clone of DrillRig: pip install -e '.\[scale\]'"):
        study.optuna_module()


@pytest.mark.slow
def test_a_try_is_a_training_and_what_it_is_worth(tmp_path):
    asked, told = question(tmp_path, objective="reward"), []
    drawn = {"gamma": 0.95, "n_epochs": 1, "n_steps": 16}
    asked.ask(drawn, lambda steps, worth: told.append((steps, worth)))
    again = []
    asked.ask(drawn, lambda steps, worth: again.append((steps, worth)) or len(again) == 2)
    assert [steps for steps, _ in told] == [128, 256, 384, 512, 640, 768, 896, 1024]
    assert again == told[:2]
    assert trial.Question.config(asked, drawn)["hyperparameters"]["gamma"] == 0.95
    assert objective.FIRST_RIG in VALIDATION_SEEDS


@pytest.mark.slow
def test_a_study_on_ray_has_the_tries_of_one_here(tmp_path):
    pytest.importorskip("ray")
    from drillrig_env.engine import engine_at

    folders = tmp_path / "here", tmp_path / "ray"
    asked = question(tmp_path, objective="reward")
    for folder, engine in zip(folders, (Local(), engine_at("ray", 1)), strict=True):
        search.search(folder, asked, 2000, None, engine, lambda line: None)
        assert (folder / "study.png").stat().st_size > 1000
    here, there = (Study(folder, asked).done for folder in folders)
    assert here[0].params == there[0].params
    assert here[0].intermediate_values == there[0].intermediate_values
