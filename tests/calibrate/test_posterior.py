"""The folder of a calibration read back: fleets that are apart, scenarios on them, and what is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest

from drillrig_env import Friction, Rig, Scenario
from drillrig_env.calibrate.posterior import FILES, Posterior, fleet_of
from drillrig_env.calibrate.unknowns import values_of
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.scales import Scales
from tests.calibrate.folder import FRICTION, NAMES, RIG, write_folder


@pytest.fixture
def folder(tmp_path):
    return write_folder(tmp_path / "my_rig")


def changed(path, change):
    content = json.loads(path.read_text(encoding="utf-8"))
    change(content)
    path.write_text(json.dumps(content), encoding="utf-8")


def test_a_folder_is_read_back(folder):
    found = Posterior.from_folder(str(folder))
    assert (found.rig, found.name, found.load) == (RIG, "my_rig", 24.0)
    assert found.friction.as_array().tolist() == FRICTION.as_array().tolist()
    assert found.intervals["k_2"] == (0.45, 0.9 * 0.45, 1.1 * 0.45)
    assert found.values.shape == (64, len(NAMES))
    assert len(found.digest) == 64


def test_the_two_halves_hold_every_draw_once(folder):
    found = Posterior.from_folder(folder)
    training, judged = found.training, found.judged
    assert len(training.rigs) == len(judged.rigs) == 32
    k = NAMES.index("k_2")
    assert {rig.k_2 for rig in training.rigs}.isdisjoint({rig.k_2 for rig in judged.rigs})
    assert sorted(rig.k_2 for rig in (*training.rigs, *judged.rigs)) == sorted(found.values[:, k])


def test_a_draw_is_a_rig_with_friction_of_its_own(folder):
    found = Posterior.from_folder(folder)
    core = EpisodeBatch(2, rig=found.rig, scenario=found.scenario(found.judged))
    core.reset(np.arange(2), np.full((2, 12), 0.5), {"rig": np.array([0, 5])})
    for place, row in enumerate((1, 11)):
        drawn = dict(zip(NAMES, found.values[row], strict=True))
        own = found.judged.rigs[(0, 5)[place]]
        assert (own.J_2, own.k_2, own.R) == (drawn["J_2"], drawn["k_2"], drawn["R"])
        assert (own.J_1, own.k_p) == (RIG.J_1, RIG.k_p)
        friction = core.friction.each()[place]
        wanted = [drawn["mu_k"] + drawn["mu_s - mu_k"], drawn["mu_k"], drawn["v_b"]]
        assert [friction.mu_s, friction.mu_k, friction.v_b] == pytest.approx(wanted, rel=1e-12)


def test_loads_reach_to_that_of_the_records(folder):
    found = Posterior.from_folder(folder)
    scenario = found.scenario(found.training)
    assert scenario.normal_force == pytest.approx((24.0 / 6.0, 24.0))
    assert scenario.speed_target == Scenario.named("default", Scales.of(RIG)).speed_target
    assert (scenario.spread, scenario.friction.mu_k) == (0.0, 0.25)
    wide = found.scenario(None, "wide")
    assert wide.normal_force == pytest.approx((1.6, 32.0))
    assert (wide.spread, wide.rigs) == (pytest.approx(0.2), None)


def test_what_a_dictionary_gives_is_kept(folder):
    found = Posterior.from_folder(folder)
    scenario = found.scenario(found.training, {"normal_force": (7.0, 8.0), "spread": 0.1, "target_skew": 2.0})
    assert (scenario.normal_force, scenario.spread, scenario.target_skew) == ((7.0, 8.0), 0.1, 2.0)
    assert scenario.friction.mu_k == 0.25


def test_the_folder_stands_for_its_files(folder):
    assert Rig.of(folder) == Rig.of(str(folder)) == RIG
    assert Friction.of(folder).mu_k == 0.25


def test_a_parameter_that_was_not_looked_for_is_the_best_fits():
    own = values_of(RIG, FRICTION)
    fleet = fleet_of(RIG, FRICTION, ["k_1"], np.array([[own["k_1"]], [2.0 * own["k_1"]]]))
    assert [rig.k_1 for rig in fleet.rigs] == [own["k_1"], 2.0 * own["k_1"]]
    assert fleet.friction == ((1.0, 1.0, 1.0), (1.0, 1.0, 1.0))


def test_draws_that_do_not_turn_steadily_are_left_out(tmp_path):
    rig = replace(RIG, k_i=1000.0)  # where a tenth of the resistance lets the drive shake by itself
    folder = write_folder(tmp_path / "my_rig", rig)
    values = Posterior.from_folder(folder).values.copy()
    values[1, NAMES.index("R")] *= 0.1
    np.savez(folder / "draws.npz", names=np.array(NAMES), values=values)
    assert len(Posterior.from_folder(folder).judged.rigs) == 31
    values[3:40:2, NAMES.index("R")] *= 0.1
    np.savez(folder / "draws.npz", names=np.array(NAMES), values=values)
    with pytest.raises(ValueError, match="my_rig: the drive turns 12 of 32 draws steadily; allowed: half of them"):
        _ = Posterior.from_folder(folder).judged


@pytest.mark.parametrize("name", FILES)
def test_a_missing_file_is_named(folder, name):
    (folder / name).unlink()
    with pytest.raises(FileNotFoundError, match=f"my_rig is no folder of a calibration: {name} is missing; allowed"):
        Posterior.from_folder(folder)


@pytest.mark.parametrize("name", FILES)
def test_a_damaged_file_is_named(folder, name):
    (folder / name).write_bytes((folder / name).read_bytes()[:25])
    with pytest.raises(ValueError, match=name):
        Posterior.from_folder(folder)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda c: c.pop("load"), r"calibration.json is damaged: parameters or load are missing \('load'\)"),
        (lambda c: c.update(load="much"), "calibration.json is damaged: load or parameters are no numbers"),
        (lambda c: c.update(load=None), "calibration.json is damaged: load or parameters are no numbers"),
        (lambda c: c.update(parameters=[1]), "calibration.json is damaged: parameters or load are missing"),
        (lambda c: c["parameters"]["R"].update(low=-1.0), "load or parameters are no numbers >= 0"),
        (lambda c: c["parameters"].update(k_9=c["parameters"]["R"]), "it has a parameter 'k_9', which no rig has"),
        (lambda c: c["parameters"].pop("R"), "draws.npz is damaged: its names are not those of calibration.json"),
        (lambda c: c["parameters"]["k_2"].update(value=0.5), "rig.toml: k_2 = 0.45 is not allowed; allowed: 0.5, of"),
        (lambda c: c["parameters"]["v_b"].update(value=2.0), "friction.toml: v_b = 1.3 is not allowed; allowed: 2"),
    ],
)
def test_a_summary_that_does_not_fit_is_refused(folder, change, said):
    changed(folder / "calibration.json", change)
    with pytest.raises(ValueError, match=said):
        Posterior.from_folder(folder)


@pytest.mark.parametrize(
    ("arrays", "said"),
    [
        ({"names": np.array(NAMES)}, "it has no arrays names and values"),
        ({"names": np.array(NAMES), "values": np.ones((64, 5))}, r"values of shape \(64, 5\) for 6 names"),
        ({"names": np.array(NAMES), "values": np.ones((64, 6), dtype=int)}, r"values of shape \(64, 6\)"),
        ({"names": np.array(NAMES), "values": np.full((64, 6), np.nan)}, "J_2 = nan is not allowed; allowed: > 0"),
        ({"names": np.array(NAMES), "values": -np.ones((64, 6))}, "J_2 = -1.0 is not allowed; allowed: > 0"),
    ],
)
def test_draws_that_are_none_are_refused(folder, arrays, said):
    np.savez(folder / "draws.npz", **arrays)
    with pytest.raises(ValueError, match=said):
        Posterior.from_folder(folder)


def test_without_a_load_there_is_no_scenario(folder):
    changed(folder / "calibration.json", lambda content: content.update(load=0.0))
    found = Posterior.from_folder(folder)
    with pytest.raises(ValueError, match="my_rig: no record had a load, so that nothing is known of the friction"):
        found.scenario(found.training)
