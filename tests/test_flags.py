import argparse
import re
from dataclasses import dataclass
from pathlib import Path

import pytest

from drillrig_env.allowed import COUNT, POSITIVE, Allowed, Choice, Made, Span, Switch
from drillrig_env.command_line import Parser
from drillrig_env.flags import add_fields, add_friction_argument, add_rig_argument, given_fields, of_kind, step
from drillrig_env.friction import Friction
from drillrig_env.parameters import check_fields, parameter
from drillrig_env.rig import Rig


@dataclass(frozen=True)
class Settings:
    speed_target: tuple[float, float] = parameter((1.0, 5.0), "rad/s", "range of targets", allowed=Span(POSITIVE))
    shape: str = parameter("square", "", "shape of the penalty", allowed=Choice(("square", "absolute")))
    loud: bool = parameter(False, "", "whether progress is shown", allowed=Switch())
    rigs: int | None = parameter(None, "", "rigs at once", allowed=COUNT, none="as many as fit")
    rig: Rig = parameter(meaning="the rig", factory=Rig, allowed=Made(Rig.of, "a file"))

    def __post_init__(self):
        check_fields(self)


@pytest.fixture
def parser():
    made = Parser(prog="drillrig try")
    add_fields(made, Settings, skip=["rig"])
    add_rig_argument(made)
    return made


def test_only_what_is_given_is_collected(parser):
    assert given_fields(parser.parse_args([]), Settings) == {"rig": None}
    given = given_fields(parser.parse_args(["--speed-target", "2:3", "--loud", "--rigs", "7"]), Settings)
    assert given == {"speed_target": (2.0, 3.0), "loud": True, "rigs": 7, "rig": None}
    assert Settings(**given).rig == Rig()


def test_help_shows_meaning_unit_and_default_of_every_field(parser):
    text = parser.format_help()
    assert "range of targets (default: (1.0, 5.0) rad/s)" in " ".join(text.split())
    assert "rigs at once (default: as many as fit)" in " ".join(text.split())
    assert "--no-loud" in text


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--speed-target", "3:2"], "argument --speed-target: '3:2' is not allowed; allowed: (low, high)"),
        (["--shape", "cube"], "argument --shape: 'cube' is not allowed; allowed: 'square' or 'absolute'"),
        (["--rigs", "1.5"], "argument --rigs: '1.5' is not allowed; allowed: whole, >= 1"),
        (["--rig", "nosuch.toml"], "argument --rig: rig: there is no file nosuch.toml"),
    ],
)
def test_what_is_not_allowed_ends_with_a_sentence(parser, words, said, capsys):
    with pytest.raises(SystemExit) as end:
        parser.parse_args(words)
    assert end.value.code == 2
    assert said in capsys.readouterr().err


def test_steps_of_a_schedule():
    assert step("3") == (0.0, 3.0)
    assert step("50:3.5") == (50.0, 3.5)
    with pytest.raises(argparse.ArgumentTypeError, match="time:value"):
        step("now")


@pytest.mark.parametrize(
    ("kind", "unit", "text", "said"),
    [
        (COUNT, "", "0", "'0' is not allowed; allowed: whole, >= 1"),
        (COUNT, "", "1.5", "'1.5' is not allowed; allowed: whole, >= 1"),
        (COUNT, "", "many", "'many' is not allowed; allowed: whole, >= 1"),
        (Allowed(low=0, whole=True), "", "-1", "'-1' is not allowed; allowed: whole, >= 0"),
        (Allowed(0, 499_999_999, whole=True), "", "500000000", "allowed: whole, >= 0 and <= 499999999"),
        (POSITIVE, "s", "0", "'0' is not allowed; allowed: > 0 s"),
        (POSITIVE, "s", "nan", "'nan' is not allowed; allowed: > 0 s"),
        (POSITIVE, "s", "inf", "'inf' is not allowed; allowed: > 0 s"),
        (POSITIVE, "s", "soon", "'soon' is not allowed; allowed: > 0 s"),
    ],
)
def test_a_word_that_is_not_of_its_kind_is_named_with_what_is_allowed(kind, unit, text, said):
    with pytest.raises(argparse.ArgumentTypeError) as found:
        of_kind(kind, unit)(text)
    assert str(found.value).endswith(said)


def test_a_word_of_its_kind_is_read():
    assert [of_kind(COUNT)(text) for text in ("2", "2e6")] == [2, 2_000_000]
    assert of_kind(POSITIVE, "s")("0.2") == 0.2


def test_no_command_has_a_number_that_is_not_of_a_kind():
    """argparse's own int and float say "invalid int value", and take what is out of range."""
    root = Path(__file__).parents[1]
    files = [root / "train.py", root / "eval.py"]
    for package in ("drillrig_env", "baselines", "agents", "benchmarks"):
        files += (root / package).rglob("*.py")
    wrong = [str(path) for path in files if re.search(r"(?<!d)type=(int|float)\b", path.read_text(encoding="utf-8"))]
    assert not wrong


def test_the_folder_of_a_calibration_gives_its_friction_too(tmp_path):
    made = Parser(prog="drillrig try")
    add_rig_argument(made)
    add_friction_argument(made)
    folder = tmp_path / "my_rig"
    folder.mkdir()
    Rig(k_1=0.9).to_toml(folder / "rig.toml")
    Friction(24.0, 0.4, 0.3).to_toml(folder / "friction.toml")
    Friction(5.0).to_toml(tmp_path / "other.toml")
    found = made.parse_args(["--rig", str(folder)])
    assert (found.rig, found.friction.normal_force, found.calibration) == (Rig(k_1=0.9), 24.0, folder)
    other = ["--friction", str(tmp_path / "other.toml")]
    for words in ([*other, "--rig", str(folder)], ["--rig", str(folder), *other]):
        found = made.parse_args(words)
        assert (found.friction.normal_force, found.calibration) == (5.0, folder)
    found = made.parse_args(["--rig", str(folder / "rig.toml")])
    assert (found.rig, found.friction, found.calibration) == (Rig(k_1=0.9), None, None)


def test_a_folder_without_a_friction_is_no_rig_of_a_calibration(tmp_path, capsys):
    made = Parser(prog="drillrig try")
    add_rig_argument(made)
    add_friction_argument(made)
    folder = ["--rig", str(tmp_path)]

    def refused(words):
        with pytest.raises(SystemExit):
            made.parse_args(words)
        return capsys.readouterr().err

    assert "argument --rig: rig: there is no file" in refused(folder)
    Rig().to_toml(tmp_path / "rig.toml")
    assert "argument --rig: friction: there is no file" in refused(folder)
    Friction().to_toml(tmp_path / "friction.toml")
    assert "argument --rig: given twice; allowed: one folder" in refused([*folder, *folder])
