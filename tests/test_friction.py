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


@pytest.mark.parametrize(("law", "share"), [("gaussian", np.exp(-0.36)), ("linear", 0.4)])
def test_other_laws_fall_by_their_own_share(law, share):
    friction = Friction(20.0, 0.6, 0.2, 2.0, law=law)
    assert friction.torque(RIG, 0.3) == pytest.approx(20.0 * RIG.r_1 * (0.2 + 0.4 * share), rel=1e-14)
    assert friction.torque(RIG, 0.3) == pytest.approx(friction.torque_discontinuous(RIG, 0.3), rel=1e-14)
    assert friction.torque(RIG, 60.0) == pytest.approx(20.0 * RIG.r_1 * 0.2, rel=1e-14)


@pytest.mark.parametrize("law", ["exponential", "gaussian", "linear"])
def test_slope_and_curvature_of_every_law_are_its_derivatives(law):
    friction, speed = Friction(30.0, 0.6, 0.2, 1.3, law=law), np.array([-3.0, -1.0, -5e-4, 2e-4, 0.01, 0.5, 2.0])
    step = 1e-6
    for value, derivative in ((friction.torque, friction.slope), (friction.slope, friction.curvature)):
        difference = (value(RIG, speed + step) - value(RIG, speed - step)) / (2 * step)
        np.testing.assert_allclose(derivative(RIG, speed), difference, rtol=1e-6, atol=1e-8)
    np.testing.assert_array_equal(friction.torque(RIG, -speed), -friction.torque(RIG, speed))


@pytest.mark.parametrize("law", ["gaussian", "linear"])
@pytest.mark.parametrize("v_b", [0.5, 400.0, 3000.0])
def test_the_straight_line_of_other_laws_ends_without_a_step(law, v_b):
    friction, edge = Friction(20.0, v_b=v_b, law=law), RIG.omega_s
    below, above = friction.torque(RIG, np.nextafter(edge, 0.0)), friction.torque(RIG, edge)
    assert below == pytest.approx(above, rel=1e-12) == pytest.approx(friction.break_loose(RIG), rel=1e-12)


def test_linear_fall_has_its_kink_where_it_meets_the_floor():
    friction = Friction(20.0, 0.5, 0.3, 4.0, law="linear")
    assert friction.slope(RIG, [0.2499, 0.2501]).tolist() == [pytest.approx(-20.0 * RIG.r_1 * 0.2 * 4.0), 0.0]


def test_law_is_kept_in_files_and_by_each_rig_of_a_batch(tmp_path):
    Friction(12.5, law="gaussian").to_toml(tmp_path / "friction.toml")
    assert Friction.of(tmp_path / "friction.toml").law == "gaussian"
    (tmp_path / "older.toml").write_text("[friction]\nnormal_force = 8\nmu_s = 0.6\nmu_k = 0.3\nv_b = 1\n")
    assert Friction.of(tmp_path / "older.toml").law == "exponential"
    batch = Friction(np.array([10.0, 20.0]), law="linear")
    assert [one.law for one in batch.each()] == ["linear", "linear"]
    assert Friction(10.0, law="linear").single().law == "linear"


def test_unknown_law_is_refused_with_the_closest_one():
    with pytest.raises(ValueError, match=r"law: 'gausian' is not known; did you mean gaussian\? allowed: exponential"):
        Friction(law="gausian")
