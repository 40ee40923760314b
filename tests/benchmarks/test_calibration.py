"""The benchmark of coverage: what is kept of each twin, what goes on after a stop, and what intervals hold."""

import json

import numpy as np
import pytest

from benchmarks import calibration
from benchmarks.coverage import Coverage, Results, page

FEW = ("--twins", "2", "--kinds", "chapter", "untrue", "--jobs", "1")


@pytest.fixture
def files(tmp_path):
    return ("--output", str(tmp_path / "page.md"), "--results", str(tmp_path / "few.json"))


def held_by_seed(twin):
    return Coverage({"L": twin[1] % 2 == 0, "R": True}, {"critical speed": True, "end of stick-slip": False}, False)


def test_a_run_that_is_stopped_goes_on_where_it_was(files, monkeypatch, tmp_path):
    asked = []

    def stopped(twin):
        asked.append(twin)
        if len(asked) == 3:
            raise KeyboardInterrupt
        return held_by_seed(twin)

    monkeypatch.setattr(calibration, "judged", stopped)
    assert calibration.main([*FEW, *files]) == 130
    assert "| `chapter` | 1 |" in (tmp_path / "page.md").read_text()
    assert calibration.main([*FEW, *files]) == 0
    assert asked == [("chapter", 1000), ("untrue", 1000), ("chapter", 1001), ("chapter", 1001), ("untrue", 1001)]
    text = (tmp_path / "page.md").read_text()
    assert "| `chapter` | 2 | 0.750 | 0.500 to 1.000 | 0.50 (`L`) | 1.00 | 0.00 | 0.00 |" in text
    assert calibration.main([*FEW, *files, "--overwrite"]) == 0
    assert len(asked) == 9


def test_a_file_of_something_else_is_refused_by_name(files, tmp_path, capsys):
    (tmp_path / "few.json").write_text(json.dumps({"twins": [["chapter", 1000, {"colour": 1}]], "provenance": {}}))
    with pytest.raises(SystemExit):
        calibration.main([*FEW, *files])
    assert "few.json does not hold the twins of this benchmark" in capsys.readouterr().err


def test_parameters_that_few_twins_determine_are_not_the_worst(tmp_path):
    results = Results(tmp_path / "few.json")
    twins = [("chapter", seed) for seed in range(4)]
    for twin in twins:
        results.add(twin, Coverage({"R": True, **({"d_2": False} if twin[1] == 0 else {})}, {"end": True}, True))
    text = page(Results.read(tmp_path / "few.json"), twins)
    assert "1.00 (`R`)" in text
    assert "| `d_2` | 0.00 of 1 |" in text


@pytest.mark.slow
def test_intervals_of_twins_hold_the_truth():
    found = [calibration.judged(("chapter", seed)) for seed in range(200, 203)]
    assert np.mean([held for one in found for held in one.parameters.values()]) >= 0.8
    assert not any(one.misfit for one in found)
