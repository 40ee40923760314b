import numpy as np
import pytest

from drillrig_env import Friction, Rig

RIG = Rig()


def test_law_4_9_at_its_corners():
    friction = Friction(20.0)
    static = 20.0 * RIG.r_1 * 0.5
    assert friction.torque(RIG, 0.0) == 0.0
    assert friction.torque(RIG, 0.5e-3) == pytest.approx(0.5 * static)
    assert friction.torque(RIG, 1e-3) == pytest.approx(static, rel=1e-3)
    assert friction.torque(RIG, 50.0) == pytest.approx(20.0 * RIG.r_1 * 0.306)


def test_laws_4_7_and_4_9_agree_outside_the_stick_zone_and_4_8_gives_plus_one_at_zero():
    friction, speed = Friction(15.0), np.array([-4.0, -0.01, 0.001, 0.3, 7.0])
    np.testing.assert_allclose(friction.torque(RIG, speed), friction.torque_discontinuous(RIG, speed), rtol=1e-12)
    assert friction.torque_discontinuous(RIG, 0.0) == pytest.approx(15.0 * RIG.r_1 * 0.5)


def test_torque_is_odd_and_slope_is_its_derivative():
    friction, speed = Friction(30.0, 0.6, 0.2, 1.3), np.array([-3.0, -1.0, -5e-4, 2e-4, 0.01, 2.0])
    np.testing.assert_array_equal(friction.torque(RIG, -speed), -friction.torque(RIG, speed))
    step = 1e-8
    difference = (friction.torque(RIG, speed + step) - friction.torque(RIG, speed - step)) / (2 * step)
    np.testing.assert_allclose(friction.slope(RIG, speed), difference, rtol=1e-5)


def test_batch_has_one_entry_a_rig():
    batch = Friction(np.array([10.0, 20.0]), 0.5)
    assert batch.as_array().shape == (2, 4)
    assert batch.torque(RIG, 2.0).tolist() == [Friction(10.0).torque(RIG, 2.0), Friction(20.0).torque(RIG, 2.0)]


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"normal_force": -1.0}, ["normal_force", "-1.0 N", ">= 0"]),
        ({"v_b": 0.0}, ["v_b", "s/rad", "> 0"]),
        ({"mu_s": 0.2}, ["mu_s", "0.2", "mu_k = 0.306"]),
        ({"normal_force": np.array([1.0, np.nan])}, ["normal_force", "nan"]),
        ({"normal_force": np.ones(2), "v_b": np.ones(3)}, ["shapes", "one entry a rig"]),
    ],
)
def test_impossible_friction_is_refused(fields, words):
    with pytest.raises(ValueError, match="Friction") as caught:
        Friction(**fields)
    for word in words:
        assert word in str(caught.value)


def test_file_holds_a_friction_of_single_numbers(tmp_path):
    friction = Friction(12.5, 0.55, 0.31, 1.1)
    friction.to_toml(tmp_path / "friction.toml")
    assert vars(Friction.from_toml(tmp_path / "friction.toml")) == vars(friction)


def test_description_has_a_line_for_every_field_with_value_and_unit():
    lines = [line.split() for line in Friction(12.5).describe().splitlines()]
    found = {words[0]: words for words in lines if words}
    assert {"normal_force", "mu_s", "mu_k", "v_b"} <= found.keys()
    assert {"12.5", "N"} <= set(found["normal_force"])
    assert {"1.0", "s/rad"} <= set(found["v_b"])


def test_friction_comes_back_from_its_file(tmp_path):
    friction = Friction(12.5, 0.61, 0.29, 1.3)
    friction.to_toml(tmp_path / "clay.toml")
    assert vars(Friction.from_toml(tmp_path / "clay.toml")) == vars(friction)
    assert vars(Friction.of(tmp_path / "clay.toml")) == vars(friction)
