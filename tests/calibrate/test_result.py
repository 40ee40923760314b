"""The folder of a calibration: whole or not there, by one at a time, and read by others."""

import json
import re

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.calibrate import borders as module
from drillrig_env.calibrate import command
from drillrig_env.calibrate.report import Report
from drillrig_env.calibrate.result import reserved, write_result
from drillrig_env.files import owned
from tests.calibrate.test_calibration import FIXED, STICKING, csv_of, fitted


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """Borders without the orbits."""
    monkeypatch.setattr(module, "_end", lambda *given: 1.5 * module._critical(*given))


def test_the_command_writes_a_folder_that_other_commands_read(tmp_path, capsys):
    csv_of(STICKING, tmp_path / "run.csv")
    fixed = [name for name in FIXED if name not in ("T_r2", "C_1", "C_2")]
    words = [
        str(tmp_path / "run.csv"),
        "--fix",
        *fixed,
        "--starts",
        "1",
        "--jobs",
        "1",
        "--output",
        str(tmp_path / "out"),
    ]
    assert command.main(words) == 0
    printed = capsys.readouterr().out
    assert "k_2" in printed
    assert "critical speed: " in printed
    assert "1 held out" in printed
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "rig.toml",
        "friction.toml",
        "calibration.json",
        "draws.npz",
        "index.html",
        "borders.png",
        "correlations.png",
        "intervals.png",
        "record_1.png",
    }
    assert {path.name for path in tmp_path.iterdir()} == {"run.csv", "out"}
    rig, friction = Rig.from_toml(tmp_path / "out" / "rig.toml"), Friction.from_toml(tmp_path / "out" / "friction.toml")
    kept = json.loads((tmp_path / "out" / "calibration.json").read_text(encoding="utf-8"))
    assert rig.k_2 == pytest.approx(kept["parameters"]["k_2"]["value"])
    assert friction.mu_k == pytest.approx(kept["parameters"]["mu_k"]["value"])
    assert len(kept["records"][0]["sha256"]) == 64
    with np.load(tmp_path / "out" / "draws.npz") as draws:
        assert draws["values"].shape == (64, len(draws["names"]))
    page = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert len(re.findall(r'src="data:image/png;base64,', page)) == 4
    assert page.count("src=") == 4  # and nothing from elsewhere
    assert kept["records"][0]["sha256"] in page
    with pytest.raises(SystemExit):
        command.main(words)
    assert "is there already" in capsys.readouterr().err


def test_a_result_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    report = Report.of(fitted(), "line", draws=0)
    for error, told in (
        (ZeroDivisionError(), None),
        (OSError(28, "No space left on device"), "the result cannot be written: no space left on device"),
    ):

        def full(*_, error=error):
            raise error

        monkeypatch.setattr("drillrig_env.calibrate.result.page", full)
        with pytest.raises(type(error), match=told), reserved(tmp_path / "out") as new:
            write_result(new, report, {})
        assert list(tmp_path.iterdir()) == []


def test_a_result_takes_the_place_of_another_when_it_is_whole(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "rig.toml").write_text("old")
    with reserved(folder, overwrite=True) as new:
        (new / "rig.toml").write_text("new")
        assert (folder / "rig.toml").read_text() == "old"
    assert (folder / "rig.toml").read_text() == "new"
    assert list(tmp_path.iterdir()) == [folder]


def test_what_a_killed_run_left_goes(tmp_path):
    hidden = tmp_path / ".out.calibrating"
    for name in ("new", "old"):
        (hidden / name).mkdir(parents=True)
        (hidden / name / "rig.toml").write_text(name)
    with pytest.raises(FileExistsError, match="out is there already"), reserved(tmp_path / "out"):
        pass  # killed between the two renames: the result that it had put aside is back
    assert (tmp_path / "out" / "rig.toml").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    (hidden / "new").mkdir(parents=True)
    with reserved(tmp_path / "out", overwrite=True) as new:
        assert list(new.iterdir()) == []
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_two_runs_do_not_write_one_folder(tmp_path):
    folder = tmp_path / "out"
    told = rf"^{re.escape(str(folder))} is in use by process \d+; wait for it"
    with owned(tmp_path / ".out.calibrating"), pytest.raises(BlockingIOError, match=told), reserved(folder):
        pass
    with reserved(folder):
        pass
    assert list(tmp_path.iterdir()) == [folder]
