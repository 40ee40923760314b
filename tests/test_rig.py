import dataclasses

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

from baselines import Constant
from drillrig_env import Friction, Rig, simulate, simulate_batch
from drillrig_env.calibrate.measured import reproduce
from drillrig_env.calibrate.records import Record
from drillrig_env.stability import critical_speed, fold_speed, stick_slip_orbit


def test_default_is_the_chapters_rig_with_unit_and_source_for_every_parameter():
    text = Rig().describe()
    for item in dataclasses.fields(Rig):
        assert item.name in text
        assert item.metadata["source"] in ("table 4.1", "text", "derived", "identified", "beyond the chapter")
    assert Rig().string_frequencies == pytest.approx((0.43, 1.82), abs=0.01)
    assert Rig().impedance == pytest.approx(0.126, abs=0.001)


@pytest.mark.parametrize(
    ("name", "value", "allowed"),
    [("J_1", -1.0, "> 0 kg m^2"), ("d_1", -0.1, ">= 0 N m s/rad"), ("k_i", 0.0, "> 0 V/rad")],
)
def test_impossible_value_names_thing_value_unit_and_range(name, value, allowed):
    with pytest.raises(ValueError, match=name) as caught:
        Rig(**{name: value})
    assert str(value) in str(caught.value)
    assert allowed in str(caught.value)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), "0.3", True, None])
def test_what_is_no_number_is_refused(value):
    with pytest.raises(ValueError, match="R = "):
        Rig(R=value)


def test_toml_round_trip(tmp_path):
    rig = Rig(k_p=1.7, L=1 / 3)
    rig.to_toml(tmp_path / "rig.toml")
    assert Rig.from_toml(tmp_path / "rig.toml") == rig
    friction = Friction(25.0, 0.45)
    friction.to_toml(tmp_path / "friction.toml")
    assert Friction.from_toml(tmp_path / "friction.toml").as_array().tolist() == friction.as_array().tolist()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("J_1 = 0.0288", "J_1 = -1", ["J_1", "-1", "kg m^2", "> 0"]),
        ("J_1 = 0.0288", "J1 = 0.0288", ["J1", "unknown key", "did you mean J_1"]),
        ("J_1 = 0.0288", "", ["J_1", "missing", "kg m^2", "> 0"]),
        ("J_1 = 0.0288", "J_1 = 'heavy'", ["J_1", "heavy", "kg m^2"]),
        ("J_1 = 0.0288", "J_1 = true", ["J_1", "not a number"]),
        ("[rig]", "[drill]", ["[rig]", "missing", "drill"]),
        ("[rig]", "[rig", ["not a TOML file"]),
    ],
)
def test_wrong_file_names_file_key_value_unit_and_range(tmp_path, old, new, words):
    path = tmp_path / "bench.toml"
    Rig().to_toml(path)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(ValueError, match=r"bench\.toml") as caught:
        Rig.from_toml(path)
    for word in words:
        assert word in str(caught.value)


def test_rig_of_takes_none_a_rig_changes_or_a_file(tmp_path):
    rig = Rig(k_p=1.7, L=1 / 3)
    rig.to_toml(tmp_path / "rig.toml")
    assert Rig.of(None) == Rig()
    assert Rig.of(rig) is rig
    assert Rig.of({"k_p": 1.7, "L": 1 / 3}) == rig
    assert Rig.of(tmp_path / "rig.toml") == Rig.of(str(tmp_path / "rig.toml")) == rig
    assert Friction.of({"normal_force": [10, 20]}).as_array().shape == (2, 4)
    assert Friction.of(None).as_array().tolist() == Friction().as_array().tolist()


@pytest.mark.parametrize("value", [5, ["J_1"], True, Friction(), {1, 2}, b"rig.toml"])
def test_rig_of_refuses_what_is_no_rig_and_says_what_is(value):
    with pytest.raises(ValueError, match="rig = ") as caught:
        Rig.of(value)
    for word in ("a Rig", "dictionary of changes", "TOML file", "[rig]"):
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"J1": 0.3}, ["unknown key J1", "did you mean J_1"]),
        ({1: 0.3}, ["unknown key 1"]),
        ({"J_1": "0.3"}, ["J_1 = '0.3' is text; write 0.3, without quotes", "> 0 kg m^2"]),
        ({"J_1": "heavy"}, ["J_1 = 'heavy' is not a number", "> 0 kg m^2"]),
        ({"J_1": True}, ["J_1 = True is not a number"]),
        ({"J_1": 1 + 0j}, ["J_1 = (1+0j) is not a number"]),
        ({"J_1": [0.3]}, ["J_1 = [0.3] kg m^2 is not allowed"]),
        ({"J_1": -1}, ["J_1 = -1 kg m^2 is not allowed", "> 0 kg m^2"]),
        ({"k_p": float("inf")}, ["k_p = inf V s/rad is not allowed"]),
    ],
)
def test_rig_of_refuses_a_change_by_its_key_value_unit_and_range(changes, words):
    with pytest.raises(ValueError, match=r"^rig: ") as caught:
        Rig.of(changes)
    for word in words:
        assert word in str(caught.value)


def test_file_of_changes_must_say_that_it_is_one(tmp_path):
    path = tmp_path / "softer.toml"
    path.write_text('[rig]\nbase = "chapter"\nk_1 = 0.9\n')
    assert Rig.of(path) == Rig(k_1=0.9)
    path.write_text("[rig]\nk_1 = 0.9\n")
    with pytest.raises(ValueError, match=r'softer\.toml.*J_1 is missing.*base = "chapter"'):
        Rig.of(path)
    path.write_text('[rig]\nbase = "mine"\nk_1 = 0.9\n')
    with pytest.raises(ValueError, match=r"base = 'mine' is not known; allowed: base = \"chapter\""):
        Rig.of(path)


def test_missing_and_unreadable_files_are_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"rig: there is no file .*nosuch\.toml"):
        Rig.of(tmp_path / "nosuch.toml")
    (tmp_path / "picture.toml").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(ValueError, match=r"picture\.toml: not a TOML file"):
        Rig.of(tmp_path / "picture.toml")


@pytest.mark.parametrize("given", ["record", "changes", "path"])
def test_a_rig_of_ones_own_is_taken_everywhere(given, tmp_path):
    rig = Rig(k_1=0.9, k_p=2.0)
    rig.to_toml(tmp_path / "rig.toml")
    value = {"record": rig, "changes": {"k_1": 0.9, "k_p": 2.0}, "path": str(tmp_path / "rig.toml")}[given]
    assert simulate(value, duration=1.0).state.tolist() == simulate(rig, duration=1.0).state.tolist()
    assert simulate_batch(value, duration=1.0).tolist() == simulate_batch(rig, duration=1.0).tolist()
    assert gymnasium.make("DrillRig-v0", rig=value).unwrapped.core.rig == rig
    assert gymnasium.make_vec("DrillRig-v0", num_envs=2, rig=value).core.rig == rig
    assert Constant(rig=value).rig == rig
    assert critical_speed(value, {"normal_force": 20.0}) == critical_speed(rig, Friction(20.0))
    assert fold_speed(value, None) == fold_speed(rig, Friction())
    assert stick_slip_orbit(value, None, 1.5).period == stick_slip_orbit(rig, Friction(), 1.5).period
    measurement = Record("run.csv", "", np.linspace(0.0, 1.0, 5), {"bit_speed": np.zeros(5)})
    mine, same = (reproduce(measurement, r, speed_reference=2.0)["bit_speed"] for r in (value, rig))
    assert mine.tolist() == same.tolist()


def test_spec_of_an_environment_with_a_rig_can_be_written_and_built_again():
    env = gymnasium.make("DrillRig-v0", rig=Rig(k_1=0.9))
    spec = EnvSpec.from_json(env.spec.to_json())
    assert gymnasium.make(spec).unwrapped.core.rig == Rig(k_1=0.9)
