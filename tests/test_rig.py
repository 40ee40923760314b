import dataclasses

import pytest

from drillrig_env import Friction, Rig


def test_default_is_the_chapters_rig_with_unit_and_source_for_every_parameter():
    text = Rig().describe()
    for item in dataclasses.fields(Rig):
        assert item.name in text
        assert item.metadata["source"] in ("table 4.1", "text", "derived", "identified")
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
