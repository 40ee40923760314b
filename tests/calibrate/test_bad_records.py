"""What cannot be a record of a rig like the one that the fit begins with is refused in a sentence, before any fit."""

import re
from dataclasses import replace

import pytest

from drillrig_env import Friction, Rig
from drillrig_env.calibrate import command
from drillrig_env.calibrate.calibration import calibrate
from tests.calibrate.test_calibration import FIXED, STICKING, UNLOADED, csv_of, twin
from tests.calibrate.test_given import FEW, fails


def with_signals(record, **factors):
    return replace(record, signals={name: factors.get(name, 1.0) * x for name, x in record.signals.items()})


def at_every(record, step):
    return replace(
        record,
        time=record.time[::step],
        signals={name: values[::step] for name, values in record.signals.items()},
        speed_reference=record.speed_reference[::step],
        normal_force=record.normal_force[::step],
    )


@pytest.mark.parametrize(
    ("record", "words"),
    [
        (with_signals(STICKING, current=1000.0), r"current is .*e\+03 A in mean, and .* takes some 1\.. A; .* another"),
        (with_signals(STICKING, current=0.001), r"current is 0\.001.* A in mean, and .* takes some 1\.. A"),
        (with_signals(UNLOADED, voltage=1000.0), r"voltage is .*e\+03 V in mean"),
        (with_signals(UNLOADED, current=-1.0), r"current is -.* A in mean; allowed: above 0"),
        (with_signals(STICKING, voltage=-1.0), r"voltage is -.* V in mean; allowed: above 0"),
        (replace(STICKING, normal_force=STICKING.normal_force / 1000.0), r"normal_force of 0\.02 N .* another unit\?"),
        (replace(STICKING, normal_force=STICKING.normal_force * 1000.0), r"normal_force of 2e\+04 N .* another unit\?"),
        (replace(STICKING, speed_reference=9.549 * STICKING.speed_reference), "is the speed reference in rpm"),
        (
            at_every(twin(2.0, 20.0, 160.0), 60),
            "a sample each 1.2 s, 1.9 in the slowest period .* allowed: 4 or more",
        ),
    ],
)
def test_what_cannot_be_of_such_a_rig_is_refused_before_the_fit(record, words, monkeypatch):
    monkeypatch.setattr("drillrig_env.calibrate.calibration.fit", fails)
    with pytest.raises(ValueError, match=f"^twin.csv: .*{words}"):
        calibrate([UNLOADED, record], None, Friction(10.0), fix=FIXED, starts=1)


def test_a_record_of_another_rig_is_taken_as_far_as_it_may_be(monkeypatch):
    monkeypatch.setattr("drillrig_env.calibrate.calibration.fit", fails)
    for rig in (replace(Rig(), K_T=5.0 * Rig().K_T), replace(Rig(), C_m=0.0, T_f=0.0)):
        with pytest.raises(AssertionError, match="before any fit"):
            calibrate([UNLOADED, STICKING], rig, Friction(100.0, 0.2, 0.1), fix=FIXED, starts=1)


@pytest.mark.slow
def test_a_model_that_is_nowhere_near_is_no_result():
    names = list(STICKING.signals)
    swapped = dict(zip(["top_speed", "bit_speed", *names[2:]], STICKING.signals.values(), strict=True))
    with pytest.raises(ValueError, match=r"twin.csv: the best model is off top_speed by .* nothing is found: is a col"):
        calibrate([replace(STICKING, signals=swapped)], None, Friction(10.0), fix=FEW, starts=1)


@pytest.mark.parametrize(
    ("record", "words"),
    [
        (at_every(STICKING, 200), "samples over .* s are too few"),
        (with_signals(STICKING, bit_speed=0.0, top_speed=0.0), "no motion in bit_speed and top_speed from 0 to 24 s"),
        (with_signals(STICKING, bit_speed=-1.0), "bit_speed is -1.* rad/s in mean; allowed: above 0"),
        (with_signals(STICKING, bit_speed=9.549, top_speed=9.549), "is top_speed in rpm"),
        (replace(STICKING, time=STICKING.time / 60.0), "length of the record = 0.4 s .* is its time in another unit"),
    ],
)
def test_the_command_says_what_is_wrong_with_a_file(record, words, tmp_path, capsys):
    csv_of(record, tmp_path / "run.csv")
    with pytest.raises(SystemExit, match="2"):
        command.main([str(tmp_path / "run.csv"), "--fix", "J_1"])
    said = capsys.readouterr().err.splitlines()[0]
    assert said.startswith(f"drillrig calibrate: error: {tmp_path / 'run.csv'}")
    assert re.search(words, said)
