"""Control designed on calibrated rigs: what is kept of each rig, what a fit that fails leaves, and what a fit finds."""

import json

import numpy as np
import pytest

from baselines.tune import tuning_suite
from benchmarks import calibrated_rigs, minute_of_records
from benchmarks.minute_of_records import NOMINAL, Found, fleet_of, found_of, kinds_of
from drillrig_env import Rig
from drillrig_env.calibrate.unknowns import values_of

OF_ONE = NOMINAL | {"k_2": 0.5}


@pytest.fixture
def few(tmp_path):
    return tmp_path / "few.json"


@pytest.fixture
def quick(monkeypatch):
    """No rig is fitted and none is judged: the numbers of those that a fit was asked for."""
    asked = []

    def fit(seed, rig):
        asked.append(rig[0])
        return Found(OF_ONE, "", 1.0)

    monkeypatch.setattr(calibrated_rigs, "found_of", fit)
    played = {name: np.ones(16, dtype=bool) for name in calibrated_rigs.POLICIES}
    monkeypatch.setattr(
        calibrated_rigs,
        "mitigated",
        lambda suite, found: {name: np.tile(one, len(found)) for name, one in played.items()},
    )
    return asked


def refused(capsys, few, *words):
    """What is said on the standard error where arguments are bad."""
    with pytest.raises(SystemExit) as end:
        calibrated_rigs.main(["--tuning", "--json", str(few), *words])
    assert end.value.code == 2
    return capsys.readouterr().err


def test_a_run_that_is_stopped_goes_on_where_it_was(few, monkeypatch, capsys):
    asked, judged = [], []

    def stopped(seed, rig):
        asked.append(rig[0])
        if len(asked) == 2:
            raise KeyboardInterrupt
        return Found(OF_ONE if rig[0] else {}, "" if rig[0] else "ValueError: off", 1.0)

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
    assert [one.values for one in judged[0]] == [{}, OF_ONE]
    assert json.loads(few.read_text())["results"]["mitigated"]["`lqg`"] == [16, 0]
    told = capsys.readouterr().out
    assert "| `lqg` | 0.500 (0.00-1.00) | | +0.000 |" in told
    assert "| `LQROfRig` * | 0.250 (0.00-0.50) | -0.250 (-0.50 +0.00) | +0.250 (+0.00 +0.50) |" in told
    assert "2 rigs; 1 of the fits failed" in told
    with pytest.raises(SystemExit):
        calibrated_rigs.main([*command, "--seed", "1"])
    assert "its seed is 0, not 1" in capsys.readouterr().err


def test_a_file_of_more_rigs_is_refused_and_left(few, quick, capsys):
    command = ["--tuning", "--json", str(few)]
    assert calibrated_rigs.main([*command, "--rigs", "2"]) == 0
    before = few.read_bytes()
    told = refused(capsys, few, "--rigs", "1")
    assert "few.json holds more rigs, up to number 1, than --rigs 1 asks for; name another file with --json" in told
    assert few.read_bytes() == before
    assert calibrated_rigs.main([*command, "--rigs", "1", "--overwrite"]) == 0
    assert len(json.loads(few.read_text())["results"]["rigs"]) == 1


def test_the_verdict_stays_until_more_rigs_are_judged(few, quick, monkeypatch):
    command = ["--tuning", "--json", str(few)]
    calibrated_rigs.main([*command, "--rigs", "1"])
    fit = calibrated_rigs.found_of

    def stopped(seed, rig):
        if rig[0] == 2:
            raise KeyboardInterrupt
        return fit(seed, rig)

    with monkeypatch.context() as patch:
        patch.setattr(calibrated_rigs, "found_of", stopped)
        assert calibrated_rigs.main([*command, "--rigs", "3"]) == 130
    results = json.loads(few.read_text())["results"]
    assert [one["rig"] for one in results["rigs"]] == [0, 1]
    assert results["mitigated"]["`lqg`"] == [16]
    calibrated_rigs.main([*command, "--rigs", "3"])
    assert json.loads(few.read_text())["results"]["mitigated"]["`lqg`"] == [16, 16, 16]
    assert quick == [0, 1, 2]


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"rigs": None}, "it has no results with rigs"),
        ({"seed": None}, "it does not tell seed"),
        ({"rigs": [{"rig": 0, "values": {}, "failed": "", "seconds": 1.0}]}, "rig 0 has neither each parameter's"),
        ({"rigs": [{"rig": 0, "values": {}, "failed": ""}]}, "rig 0: seconds = None is not a number"),
        ({"rigs": [{"rig": 0, "values": {"k": 1.0}, "failed": "", "seconds": 1.0}]}, "rig 0 has neither each"),
        (
            {"rigs": [{"rig": 0, "values": NOMINAL | {"J_1": -1.0}, "failed": "", "seconds": 1.0}]},
            "rig 0: Rig: J_1 = -1.0 kg m^2 is not allowed",
        ),
        ({"rigs": [{"rig": 0, "values": NOMINAL | {"v_b": "x"}, "failed": "", "seconds": 1.0}]}, "rig 0: "),
        ({"rigs": [{"rig": 256, "values": {}, "failed": "off", "seconds": 1.0}]}, "rigs: rig = 256 is not allowed"),
        ({"rigs": [{"rig": 0, "values": {}, "failed": "off", "seconds": 1.0}] * 2}, "it has a rig twice"),
        ({"rigs": ["rig"]}, "'rig' is no rig"),
        ({"mitigated": [16]}, "mitigated has no counts by policy"),
        ({"mitigated": {"`lqg`": [16, 16]}}, "mitigated has not a count for each of the first rigs"),
        ({"mitigated": {"`lqg`": [17]}}, "mitigated: `lqg` = 17 is not allowed; allowed: whole, >= 0 and <= 16"),
    ],
)
def test_a_damaged_file_is_told_before_any_fit(few, quick, capsys, changes, fault):
    calibrated_rigs.main(["--tuning", "--json", str(few), "--rigs", "1"])
    content = json.loads(few.read_text())
    results = {name: one for name, one in (content["results"] | changes).items() if one is not None}
    few.write_text(json.dumps({**content, "results": results}))
    quick.clear()
    told = refused(capsys, few, "--rigs", "2")
    assert f"few.json is damaged: {fault}" in told
    assert "; name another file with --json, or begin anew with --overwrite" in told
    assert not quick


def test_the_file_that_is_kept_can_go_on():
    found, verdict = calibrated_rigs._of_before(calibrated_rigs.FILE, {"seed": 0, "tuning": False}, 64)
    assert list(found) == list(range(64))
    assert {len(counts) for counts in verdict.values()} == {64}


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
