"""The records that the tutorial ships: what the command makes, and what is read of them."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.twin import FOLDER, FRICTION, GLITCHES, RIG, files, main
from drillrig_env import Friction, Rig
from drillrig_env.calibrate.records import read_record
from tests.calibrate.folder import write_folder

MADE = files()


def numbers(text):
    return np.array([[float(cell) for cell in line.replace(",", ".").split(";")] for line in text.splitlines()[1:]])


@pytest.mark.parametrize("name", [name for name in MADE if name.endswith(".csv")])
def test_what_is_shipped_is_what_the_command_makes(name):
    shipped = (FOLDER / name).read_text(encoding="utf-8")
    assert shipped.splitlines()[0] == MADE[name].splitlines()[0]
    steps = [0.01, 0.1, 0.1, 0.01, 0.05, 0.01, 0.1]  # on another processor a last digit may be another
    assert np.all(np.abs(numbers(shipped) - numbers(MADE[name])) <= 1.01 * np.array(steps))


def test_the_true_rig_is_in_a_file_of_its_own():
    assert (FOLDER / "truth.toml").read_text(encoding="utf-8") == MADE["truth.toml"]
    assert Rig.of(FOLDER / "truth.toml") == RIG
    assert Friction.of(FOLDER / "truth.toml").as_dict() == FRICTION.as_dict()


def test_the_files_are_small_and_read_without_being_told_anything():
    paths = sorted(FOLDER.glob("*.csv"))
    assert sum(path.stat().st_size for path in paths) <= 400_000
    for path in paths:
        record = read_record(path)
        told = " ".join(record.notes)
        assert set(record.signals) == {"bit_speed", "top_speed", "current", "voltage"}
        assert "gaps: 1" in told
        masked = np.isnan(record.signals["bit_speed"]).sum()
        assert GLITCHES - 1 <= masked <= GLITCHES  # one may hide in a quick motion
        assert record.normal_force.max() == (0.0 if path.stem == "steps" else 24.0)
        assert record.speed_reference is not None


def test_the_command_writes_where_it_is_told(tmp_path, capsys):
    assert main(["--output", str(tmp_path / "twin")]) == 0
    assert {path.name for path in (tmp_path / "twin").iterdir()} == set(MADE)
    assert "stick_slip.csv" in capsys.readouterr().out


def test_a_calibration_is_held_beside_the_truth(tmp_path, capsys):
    folder = write_folder(tmp_path / "my_rig", RIG, FRICTION, names=("k_2", "v_b"))
    assert main(["--beside", str(folder)]) == 0
    told = capsys.readouterr().out
    assert "| k_2 | 0.47 | 0.47 | 0.423 to 0.517 | yes |" in told
    assert "critical speed at 24 N: 3.310 rad/s, by the calibration 3.310" in told
    off = write_folder(tmp_path / "off", replace(RIG, k_2=0.6), FRICTION, names=("k_2",))
    assert main(["--beside", str(off)]) == 0
    assert "| k_2 | 0.47 | 0.6 | 0.54 to 0.66 | no |" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["--beside", str(tmp_path / "nosuch")])
    assert "rig.toml is missing" in capsys.readouterr().err
