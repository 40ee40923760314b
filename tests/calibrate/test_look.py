"""What records can tell before any fit, and what is advised where they tell little."""

from dataclasses import replace

import numpy as np
import pytest

from drillrig_env import Friction
from drillrig_env.calibrate import command
from drillrig_env.calibrate.look import look
from drillrig_env.calibrate.pictures.look import draw_look
from tests.calibrate.test_calibration import FIXED, LOOKED_FOR, STICKING, UNLOADED, csv_of

FEW = dict.fromkeys(FIXED | dict.fromkeys(LOOKED_FOR[3:]))
FRICTION = Friction(20.0)


def test_records_tell_beforehand_what_they_can_tell():
    unloaded, sticking, both = (
        dict(zip(found.names, found.deviations, strict=True))
        for found in (look(records, fix=FIXED) for records in ([UNLOADED], [STICKING], [UNLOADED, STICKING]))
    )
    assert unloaded["mu_k"] == pytest.approx(np.log(3.0), rel=1e-6)
    assert sticking["mu_k"] < 0.2
    for name in LOOKED_FOR:
        assert both[name] <= min(unloaded[name], sticking[name]) * 1.001


def test_a_look_takes_the_windows_of_a_fit():
    short, usual = (look([STICKING], fix=FEW, window=window).deviations for window in (2.0, None))
    assert (short != usual).all()
    with pytest.raises(ValueError, match="no record is given"):
        look([])


def test_an_open_scale_of_torques_is_found_and_what_closes_it():
    records = [STICKING, UNLOADED]
    found = look(records, None, FRICTION)
    assert {"v_b", "R", "K_E"} <= set(found.told)
    assert not {"J_1", "J_2", "k_2", "K_T", "mu_k"} & set(found.told)
    (advice,) = found.advice()
    assert advice.startswith("One common scale of all torques is open: fix or weigh J_1 (--fix J_1=VALUE, ")
    promised = set(advice.split("tell ")[-1].removesuffix(" too").replace(" and ", ", ").split(", "))
    weighed = look(records, None, FRICTION, weigh={"J_1": 0.02})
    assert set(weighed.told) == {*found.told, *promised}
    fixed = look(records, None, FRICTION, fix={"J_1": None})
    assert fixed.advice() == ["These records can tell every parameter that is looked for"]


def test_what_else_is_to_be_recorded_is_told():
    unloaded = look([UNLOADED], None, FRICTION, fix={"J_1": None}).advice()
    assert unloaded == ["No record has a load, and nothing tells mu_k, mu_s - mu_k and v_b: add a record under load"]
    lossy = look([STICKING], None, FRICTION, fix={"J_1": None}).advice()
    assert lossy == ["These records hardly tell C_m: fix or weigh that, or add records of another kind"]
    speeds = {name: STICKING.signals[name] for name in ("bit_speed", "top_speed")}
    mechanics = look([replace(STICKING, signals=speeds)], None, FRICTION, fix={"J_1": None}).advice()
    assert mechanics[0].startswith("Log current and voltage for L, R, K_T, K_E, ")


def test_a_look_is_drawn():
    found = look([UNLOADED], None, FRICTION, fix=FIXED)
    picture = draw_look(found)
    axes = picture.figure.axes[0]
    widths = {name: bar.get_width() for name, bar in zip(found.names, axes.patches, strict=True)}
    assert widths["mu_k"] == pytest.approx(100.0 * np.log(3.0), rel=1e-6)
    assert [text.get_text() for text in axes.get_yticklabels()] == list(found.names)
    assert "No record has a load" in picture.caption


def test_the_command_looks_before_it_fits(tmp_path, capsys):
    csv_of(UNLOADED, tmp_path / "run.csv")
    words = [
        str(tmp_path / "run.csv"),
        "--look",
        "--fix",
        *(name for name in FEW if name not in ("T_r2", "C_1", "C_2")),
    ]
    assert command.main(words) == 0
    printed = capsys.readouterr().out
    assert "relative standard deviation" in printed
    assert "These records can tell every parameter" in printed
    assert command.main([*words, "--output", str(tmp_path / "look.png")]) == 0
    assert (tmp_path / "look.png").read_bytes().startswith(b"\x89PNG")
    for path, told in (("look.png", "is there already"), ("folder", "with --look it is a picture")):
        with pytest.raises(SystemExit):
            command.main([*words, "--output", str(tmp_path / path)])
        assert told in capsys.readouterr().err
