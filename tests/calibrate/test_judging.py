"""Suites on a calibrated rig: whose rigs, which friction, which loads."""

import numpy as np
import pytest

from drillrig_env.calibrate.judging import judged_suite
from drillrig_env.calibrate.posterior import Posterior
from drillrig_env.cli import evaluate
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.store import read
from drillrig_env.evaluation.suites import OF_ONE_RIG, suite
from drillrig_env.policy import make_policy
from drillrig_env.scales import Scales
from tests.calibrate.folder import FRICTION, RIG, write_folder

SCALES = Scales.of(RIG)


@pytest.fixture(scope="module")
def posterior(tmp_path_factory):
    return Posterior.from_folder(write_folder(tmp_path_factory.mktemp("results") / "my_rig"))


@pytest.mark.parametrize("name", OF_ONE_RIG)
def test_a_suite_takes_the_judged_rigs_in_turn(name, posterior):
    found = judged_suite(suite(name, 40, SCALES), posterior)
    assert found.scenario.rigs.rigs == posterior.judged.rigs
    assert found.description.endswith(", on 32 rigs that the records of my_rig allow")
    places = np.concatenate([options["rig"] for _, options in found.groups])
    np.testing.assert_array_equal(places, np.arange(found.rigs) % 32)


def test_loads_that_a_suite_gives_go_with_those_of_the_records(posterior):
    ten, twenty, stepped = judged_suite(suite("chapter", 40, SCALES), posterior).groups
    share = FRICTION.normal_force / 30.0
    assert ten[1]["normal_force"] == pytest.approx(10.0 * share)
    assert twenty[1]["normal_force"] == pytest.approx(20.0 * share)
    assert stepped[1]["normal_force"] == 0.0
    assert stepped[1]["load_steps"] == [(10.0 * SCALES.time, pytest.approx(25.0 * share))]


def test_episodes_have_the_draws_friction_and_no_other_spread(posterior):
    one = judged_suite(suite("default", 40, SCALES), posterior)
    episodes = run(make_policy("constant", rig=RIG, slew_limit=one.slew_limit), one, rig=RIG)
    factors = np.array(posterior.judged.friction)[episodes.place]
    np.testing.assert_allclose(episodes.friction.mu_k, 0.25 * factors[:, 0], rtol=1e-12)
    np.testing.assert_allclose(episodes.friction.v_b, 1.3 * factors[:, 2], rtol=1e-12)
    assert episodes.friction.normal_force.max() <= FRICTION.normal_force


def test_a_suite_of_a_fleet_keeps_its_rigs(posterior):
    unknown = suite("unknown", 8, SCALES)
    found = judged_suite(unknown, posterior)
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
