"""Suites on a calibrated rig: whose rigs, which friction, which loads."""

from dataclasses import replace

import numpy as np
import pytest

from drillrig_env import Friction
from drillrig_env.calibrate.posterior import Posterior
from drillrig_env.calibrate.verdict_rigs import VerdictRigs
from drillrig_env.cli import evaluate
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.store import read
from drillrig_env.evaluation.suites import OF_ONE_RIG, suite
from drillrig_env.policy import make_policy
from drillrig_env.scales import Scales
from drillrig_env.toml import section_text
from tests.calibrate.folder import FRICTION, RIG, write_folder

SCALES = Scales.of(RIG)


@pytest.fixture(scope="module")
def posterior(tmp_path_factory):
    return Posterior.from_folder(write_folder(tmp_path_factory.mktemp("results") / "my_rig"))


def judged(one, posterior):
    return VerdictRigs.of(None, posterior, RIG, [one.name]).suite(one)


@pytest.mark.parametrize("name", OF_ONE_RIG)
def test_a_suite_takes_the_judged_rigs_in_turn(name, posterior):
    found = judged(suite(name, 40, SCALES), posterior)
    assert found.scenario.rigs.rigs == posterior.judged.rigs
    assert found.description.endswith(", on 32 rigs that the records of my_rig allow")
    places = np.concatenate([options["rig"] for _, options in found.groups])
    np.testing.assert_array_equal(places, np.arange(found.rigs) % 32)


def test_loads_that_a_suite_gives_go_with_those_of_the_records(posterior):
    ten, twenty, stepped = judged(suite("chapter", 40, SCALES), posterior).groups
    share = FRICTION.normal_force / 30.0
    assert ten[1]["normal_force"] == pytest.approx(10.0 * share)
    assert twenty[1]["normal_force"] == pytest.approx(20.0 * share)
    assert stepped[1]["normal_force"] == 0.0
    assert stepped[1]["load_steps"] == [(10.0 * SCALES.time, pytest.approx(25.0 * share))]


def test_episodes_have_the_draws_friction_and_no_other_spread(posterior):
    one = judged(suite("default", 40, SCALES), posterior)
    episodes = run(make_policy("constant", rig=RIG, slew_limit=one.slew_limit), one, rig=RIG)
    factors = np.array(posterior.judged.friction)[episodes.place]
    np.testing.assert_allclose(episodes.friction.mu_k, 0.25 * factors[:, 0], rtol=1e-12)
    np.testing.assert_allclose(episodes.friction.v_b, 1.3 * factors[:, 2], rtol=1e-12)
    assert episodes.friction.normal_force.max() <= FRICTION.normal_force


def test_a_suite_of_a_fleet_keeps_its_rigs(posterior):
    unknown = suite("unknown", 8, SCALES)
    found = judged(unknown, posterior)
    assert found.scenario.rigs == unknown.scenario.rigs
    assert found.scenario.friction.mu_k == 0.25
    assert "records" not in found.description


def test_the_command_designs_for_the_best_fit_and_names_the_draws(posterior, tmp_path, capsys):
    words = ["constant", "lqg", "--rig", str(posterior.folder), "--suite", "default", "--rigs", "32", "--no-pictures"]
    assert evaluate.main([*words, "--output", str(tmp_path)]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "on 32 rigs that the records of my_rig allow (32 episodes, DrillRig-v0) policy" in told
    results = read(tmp_path)
    assert results.config["calibration"] == {"folder": "my_rig", "draws": posterior.digest}
    assert results.config["friction"] == {**FRICTION.as_dict(), "normal_force": 24.0}
    assert results.config["rig"]["k_2"] == RIG.k_2
    assert set(results.scores["default"]["lqg"]["rig"]) == set(range(32))


@pytest.mark.parametrize(("file", "said"), [("draws.npz", "draws.npz is missing"), ("rig.toml", "rig.toml")])
def test_the_command_names_what_is_missing(file, said, tmp_path, capsys):
    folder = write_folder(tmp_path / "my_rig")
    (folder / file).unlink()
    with pytest.raises(SystemExit) as end:
        evaluate.main(["constant", "--rig", str(folder), "--output", str(tmp_path / "out")])
    assert end.value.code == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.fixture
def true_rig(tmp_path):
    path = tmp_path / "truth.toml"
    text = section_text(replace(RIG, J_1=0.035, k_p=9.0), "rig") + section_text(Friction(18.0, 0.4, 0.2), "friction")
    path.write_text(text, encoding="utf-8")
    return path


def test_the_rig_that_turns_may_be_another_than_the_one_designed_for(true_rig):
    rigs = VerdictRigs.of(true_rig, None, RIG, ["default"])
    found = rigs.suite(suite("default", 8, SCALES))
    assert found.description.endswith(", on the rig of truth.toml")
    episodes = run(make_policy("constant", rig=RIG, slew_limit=found.slew_limit), found, rig=RIG)
    assert episodes.task.rig == RIG
    assert episodes.rigs == (replace(RIG, J_1=0.035),)  # with the drive set as on the nominal one
    assert (episodes.friction.mu_s, episodes.friction.mu_k) == pytest.approx((0.4, 0.2))
    assert episodes.friction.normal_force.max() <= 18.0
    assert episodes.friction.normal_force.min() >= 18.0 / 6.0


def test_the_command_tells_which_rig_turns(true_rig, posterior, tmp_path, capsys):
    words = [
        "constant",
        "--rig",
        str(posterior.folder),
        "--judged-on",
        str(true_rig),
        "--suite",
        "default",
        "--rigs",
        "8",
    ]
    assert evaluate.main([*words, "--no-pictures", "--output", str(tmp_path / "out")]) == 0
    assert "on the rig of truth.toml (8 episodes" in " ".join(capsys.readouterr().out.split())
    assert read(tmp_path / "out").config["suites"]["default"]["scenario"]["rigs"]["rigs"][0]["J_1"] == 0.035


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--judged-on", "nosuch.toml"], "rig: there is no file nosuch.toml"),
        (["--judged-on", "rig.toml"], "rig.toml: the table [friction] is missing"),
        (["--judged-on", "idle.toml"], "idle.toml: normal_force = 0.0 N is not allowed; allowed: > 0, the largest"),
        (
            ["--judged-on", "truth.toml", "--suite", "unknown"],
            "the suite unknown has rigs of its own; allowed on a rig: ",
        ),
        (
            ["--judged-on", "truth.toml", "--rig", "shaking.toml"],
            "truth.toml: the rig does not turn steadily with the drive",
        ),
    ],
)
def test_a_rig_that_cannot_turn_is_refused(words, said, true_rig, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    RIG.to_toml("rig.toml")
    idle = section_text(RIG, "rig") + section_text(Friction(0.0), "friction")
    (tmp_path / "idle.toml").write_text(idle, encoding="utf-8")
    replace(RIG, k_i=1e4, R=10.0).to_toml("shaking.toml")
    with pytest.raises(SystemExit):
        evaluate.main(["constant", *words, "--output", "out"])
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
