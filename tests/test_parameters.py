import dataclasses
import importlib
import pkgutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import agents
import baselines
import drillrig_env
from drillrig_env import Fleet, Scenario, Tilt
from drillrig_env.allowed import COUNT, NOT_NEGATIVE, POSITIVE, SHARE, Allowed, Choice, File, Made, Span, Switch, Text
from drillrig_env.friction import Friction
from drillrig_env.parameters import check_fields, checked, closest, default_of, describe, field_rows, parameter, refuse


@dataclass(frozen=True)
class Drilling:
    """A record with a field of every kind."""

    speed: tuple[float, float] = parameter((1.0, 5.0), "rad/s", "range of targets", allowed=Span(POSITIVE))
    law: str = parameter("square", "", "shape of the penalty", allowed=Choice(("square", "absolute")))
    loud: bool = parameter(False, "", "whether progress is shown", allowed=Switch())
    rigs: int = parameter(4, "", "rigs at once", allowed=COUNT)
    force: float | None = parameter(None, "N", "what N_1 steps to", allowed=NOT_NEGATIVE, none="as before")
    friction: Friction = parameter(
        meaning="nominal friction", factory=Friction, allowed=Made(Friction.of, "a Friction, changes or a file")
    )
    name: str = parameter("run", "", "name of the run", allowed=Text("a name"))
    folder: Path = parameter(Path("runs"), "", "where runs go", allowed=File("a folder"))

    def __post_init__(self) -> None:
        check_fields(self)


def test_fields_are_kept_as_their_kind_reads_them():
    drilling = Drilling(
        speed=[2, 3], rigs=np.int64(7), force=np.float32(2), friction={"mu_s": 0.6}, folder="there", loud=np.True_
    )
    assert drilling.speed == (2.0, 3.0)
    assert isinstance(drilling.speed, tuple)
    assert (type(drilling.rigs), drilling.rigs) == (int, 7)
    assert (type(drilling.force), drilling.force) == (float, 2.0)
    assert (Drilling(rigs=2**70).rigs, Drilling(force=2**70).force) == (2**70, 2.0**70)
    assert drilling.friction.mu_s == 0.6
    assert drilling.folder == Path("there")
    assert drilling.loud is True
    assert Drilling().force is None
    assert Drilling().friction is not Drilling().friction


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"speed": "12"}, ["speed = '12' is text"]),
        ({"speed": (5, 1)}, ["speed = (5, 1) rad/s is not allowed", "low <= high", "> 0 rad/s"]),
        ({"speed": (0, 1)}, ["speed = (0, 1) rad/s"]),
        ({"speed": (1, 2, 3)}, ["(1, 2, 3)"]),
        ({"speed": 3}, ["speed = 3 rad/s"]),
        ({"speed": (True, "x")}, ["is not a number"]),
        ({"law": "cube"}, ["law = 'cube' is not allowed", "'square' or 'absolute'"]),
        ({"law": 3}, ["law = 3"]),
        ({"loud": 1}, ["loud = 1 is not allowed", "True or False"]),
        ({"rigs": 1.5}, ["rigs = 1.5 is not allowed", "whole, >= 1"]),
        ({"rigs": "4"}, ["rigs = '4' is text; write 4, without quotes"]),
        ({"rigs": None}, ["rigs = None is not a number"]),
        ({"rigs": -(2**70)}, ["rigs = -1180591620717411303424 is not allowed", "whole, >= 1"]),
        ({"force": 10**400}, ["0 N is not allowed", ">= 0 N"]),
        ({"force": -1}, ["force = -1 N", ">= 0 N"]),
        ({"force": 1j}, ["force = 1j is not a number"]),
        ({"force": [1.0, [2.0]]}, ["force = [1.0, [2.0]] is not a number"]),
        ({"friction": {"mu": 1}}, ["Drilling: friction: unknown key mu", "did you mean"]),
        ({"friction": 3}, ["friction = 3", "a dictionary of changes"]),
        ({"name": ""}, ["name", "a name"]),
        ({"folder": 3}, ["folder = 3", "a folder"]),
    ],
)
def test_what_is_not_allowed_is_refused_in_a_sentence(fields, words):
    with pytest.raises(ValueError, match=r"^Drilling: ") as caught:
        Drilling(**fields)
    for word in words:
        assert word in str(caught.value)


def test_every_kind_reads_the_text_of_a_command_line():
    texts = {
        "speed": "2:3",
        "law": "absolute",
        "loud": "yes",
        "rigs": "2e1",
        "force": "7.5",
        "name": "a",
        "folder": "b",
    }
    kinds = {item.name: item.metadata["allowed"] for item in dataclasses.fields(Drilling)}
    read = {name: kinds[name].parse(text) for name, text in texts.items()}
    assert read == {
        "speed": (2.0, 3.0), "law": "absolute", "loud": True, "rigs": 20, "force": 7.5, "name": "a", "folder": Path("b")
    }  # fmt: skip
    assert kinds["speed"].parse("2") == (2.0, 2.0)
    for name, text in {"speed": "3:2", "law": "cube", "loud": "perhaps", "rigs": "1.5", "force": "much"}.items():
        with pytest.raises(ValueError):  # noqa: PT011  (the sentence is made where the field is known)
            kinds[name].parse(text)


@pytest.mark.parametrize(
    ("value", "holds"),
    [
        (0.5, True), (1, True), (np.array([0.0, 1.0]), True), ([0.2, 0.3], True), (1.01, False), (-0.01, False),
        (np.nan, False), ("0.5", False), (True, False), (np.array([True]), False), (0.5 + 0j, False), (None, False),
        (np.array([0.5, None]), False), ([0.1, [0.2]], False),
    ],
)  # fmt: skip
def test_an_interval_holds_finite_numbers_and_nothing_else(value, holds):
    assert SHARE.holds(value) is holds


def test_intervals_say_what_they_allow():
    assert str(Allowed()) == "any finite number"
    assert str(Allowed(whole=True)) == "any whole number"
    assert str(Allowed(0, 1, high_open=True)) == ">= 0 and < 1"
    assert Allowed(0, 1, high_open=True).holds(0.0)
    assert not Allowed(0, 1, high_open=True).holds(1.0)
    assert not POSITIVE.holds(0.0)
    assert str(Span(POSITIVE)) == "(low, high) with low <= high, each > 0"


def test_a_single_argument_is_checked_as_a_field_is():
    assert checked("simulate", "duration", 3, "s", POSITIVE) == 3.0
    with pytest.raises(ValueError, match=r"simulate: duration = '3' is text; write 3, without quotes; allowed: > 0 s"):
        checked("simulate", "duration", "3", "s", POSITIVE)
    assert "is text" not in str(refuse("reset options", "start", "5", "", "rest or steady"))


def test_unknown_names_come_with_the_closest_known_one():
    assert closest("J1", ["J_1", "k_1"]) == "did you mean J_1? allowed: J_1, k_1"
    assert closest("zzz", ["J_1"]) == "allowed: J_1"


def test_tables_show_every_field_with_default_unit_and_meaning():
    rows = {row[0]: row[1:] for row in field_rows(Drilling)}
    assert rows["rigs"] == ("4", "", "whole, >= 1", "rigs at once")
    assert rows["force"] == ("as before", "N", ">= 0", "what N_1 steps to")
    assert list(rows) == [item.name for item in dataclasses.fields(Drilling)]
    assert "what N_1 steps to" in describe(Drilling())


def documented_records():
    """Every dataclass of the project with documented fields."""
    found = {}
    for package in (drillrig_env, baselines, agents):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not module.name.endswith("__main__"):
                for thing in vars(importlib.import_module(module.name)).values():
                    if isinstance(thing, type) and dataclasses.is_dataclass(thing):
                        items = dataclasses.fields(thing)
                        if any("meaning" in item.metadata for item in items):
                            found[thing.__name__] = thing
    return found


UNITS = ("", "kg m^2", "m", "N", "N m", "N m/rad", "N m s/rad", "N m/A", "V s/rad", "V/rad", "H", "ohm", "V", "A",
         "Pa s", "s", "s/rad", "rad", "rad/s", "rad/s^2", "steps", "control steps", "rigs", "episodes", "threads",
         "px", "bytes", "1/s")  # fmt: skip


@pytest.mark.parametrize("record", documented_records().values(), ids=lambda record: record.__name__)
def test_every_field_of_a_documented_record_has_meaning_unit_and_a_default_that_is_allowed(record):
    assert record.__doc__
    for item in dataclasses.fields(record):
        meta = item.metadata
        assert meta.get("meaning"), f"{record.__name__}.{item.name} has no meaning"
        assert meta["unit"] in UNITS, f"{record.__name__}.{item.name}: unit {meta['unit']!r}"
        default = default_of(item)
        if default is not dataclasses.MISSING and default is not None:
            meta["allowed"].read(default)
        assert default is not None or meta["none"], f"{record.__name__}.{item.name}: what does None stand for?"


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Tilt(turns=65), "Tilt: turns = 65 is not allowed"),
        (lambda: Scenario(tilt={"share": 2.0}), "Scenario: tilt: share = 2.0 is not allowed"),
        (lambda: Scenario(wandering=3), "Scenario: wandering: wandering = 3 is not allowed"),
        (lambda: Scenario(rigs=Fleet.around(spread={"string": 1e9})), "Fleet: spread: string = 1000000000.0 is not"),
    ],
)
def test_what_is_wrong_within_a_field_is_named_once(make, sentence):
    with pytest.raises(ValueError, match=f"^{sentence}"):
        make()
