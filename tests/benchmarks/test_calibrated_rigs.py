"""Control designed on calibrated rigs: what is kept of each rig, what a fit that fails leaves, and what a fit finds."""

import json

import numpy as np
import pytest

from baselines.tune import tuning_suite
from benchmarks import calibrated_rigs, minute_of_records
from benchmarks.minute_of_records import NOMINAL, Found, fleet_of, found_of, kinds_of
from drillrig_env import Rig
from drillrig_env.calibrate.unknowns import values_of


@pytest.fixture
def few(tmp_path):
    return tmp_path / "few.json"


def test_a_run_that_is_stopped_goes_on_where_it_was(few, monkeypatch, capsys):
    asked, judged = [], []

    def stopped(seed, rig):
        asked.append(rig[0])
        if len(asked) == 2:
            raise KeyboardInterrupt
        return Found({"k_2": 0.5} if rig[0] else {}, "" if rig[0] else "ValueError: off", 1.0)

    def played(suite, found):
        judged.append(found)
        return {name: np.arange(32) < (8 if name == "`LQROfRig` *" else 16) for name in calibrated_rigs.POLICIES}

    monkeypatch.setattr(calibrated_rigs, "found_of", stopped)
    monkeypatch.setattr(calibrated_rigs, "mitigated", played)
    command = ["--rigs", "2", "--tuning", "--json", str(few)]
    assert calibrated_rigs.main(command) == 130
    assert len(json.loads(few.read_text())["results"]["rigs"]) == 1
    assert not judged
    assert calibrated_rigs.main(command) == 0
    assert asked == [0, 1, 1]
    assert [one.values for one in judged[0]] == [{}, {"k_2": 0.5}]
    assert json.loads(few.read_text())["results"]["mitigated"]["`lqg`"] == [16, 0]
    told = capsys.readouterr().out
    assert "| `lqg` | 0.500 (0.00-1.00) | | +0.000 |" in told
    assert "| `LQROfRig` * | 0.250 (0.00-0.50) | -0.250 (-0.50 +0.00) | +0.250 (+0.00 +0.50) |" in told
    assert "2 rigs; 1 of the fits failed" in told
    with pytest.raises(SystemExit):
        calibrated_rigs.main([*command, "--seed", "1"])
    assert "its seed is 0, not 1" in capsys.readouterr().err


def test_a_fit_that_fails_leaves_the_nominal_rig_in_its_place(monkeypatch):
    def off(record):
        raise ValueError("the model is off")

    kinds = kinds_of(tuning_suite("unknown", 1))
    monkeypatch.setattr(minute_of_records, "fitted", off)
    failed = found_of(0, (0, kinds[0]))
    assert (failed.values, failed.failed) == ({}, "ValueError: the model is off")
    true = values_of(kinds[0].rig, kinds[0].friction)
    members = fleet_of([Found(true, "", 0.0), failed]).members()
    assert members.rigs == (kinds[0].rig, Rig())
    mu_k, fall, v_b = members.friction[0] * [NOMINAL[name] for name in ("mu_k", "mu_s - mu_k", "v_b")]
    assert (mu_k, mu_k + fall, v_b) == pytest.approx(
        [getattr(kinds[0].friction, one) for one in ("mu_k", "mu_s", "v_b")]
    )
    assert members.friction[1].tolist() == [1.0, 1.0, 1.0]


@pytest.mark.slow
def test_a_minute_of_records_tells_most_of_what_a_controller_needs():
    kinds = kinds_of(tuning_suite("unknown", 3))
    found = found_of(0, (2, kinds[2]))
    assert not found.failed
    true = values_of(kinds[2].rig, kinds[2].friction)
    assert abs(np.log(found.values["k_2"] / true["k_2"])) < 0.3
    assert abs(np.log(found.values["K_E"] / true["K_E"])) < 0.05
