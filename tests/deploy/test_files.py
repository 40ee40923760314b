"""The files of policies: they act as the policies, say what they hold, and are whole or refused."""

import json

import numpy as np
import pytest

from baselines import LQG, Constant, JumpEase, ZTorque
from drillrig_env.deploy import Controller, Limits, Supervisor
from drillrig_env.deploy.about import NO_DIGEST
from drillrig_env.deploy.export import TOLERANCE, export, largest_difference, main, policy_to_export
from drillrig_env.deploy.policy_file import SHIPPED, PolicyFile, shipped_policies
from drillrig_env.deploy.ship import POLICIES
from drillrig_env.env.sensors import LIMIT, SENSORS
from drillrig_env.rig import Rig

onnx = pytest.importorskip("onnx")
pytest.importorskip("onnxruntime")

FAST = Rig(J_1=Rig().J_1 / 4.0, J_2=Rig().J_2 / 4.0, J_3=Rig().J_3 / 4.0)  # twice as fast as the chapter's


@pytest.mark.parametrize(
    "law",
    [
        lambda: Constant(sensors="surface"),
        lambda: ZTorque(sensors="encoders"),
        lambda: ZTorque(sensors="surface", rig=FAST),
        lambda: LQG(sensors="state"),
        lambda: LQG(sensors="surface", rig=FAST, delay=2),
        lambda: LQG(sensors="encoders"),
    ],
)
def test_a_law_acts_in_its_file_as_outside(law, tmp_path):
    export(law(), tmp_path / "law.onnx")
    assert largest_difference(law(), tmp_path / "law.onnx", episodes=6, steps=120) < TOLERANCE


def test_a_law_with_another_gain_would_be_noticed(tmp_path):
    export(ZTorque(sensors="surface", gain=4.0), tmp_path / "law.onnx")
    other = ZTorque(sensors="surface", gain=4.001)
    assert largest_difference(other, tmp_path / "law.onnx", episodes=3, steps=60) > TOLERANCE


@pytest.mark.parametrize("name", POLICIES)
def test_a_shipped_file_acts_as_its_policy(name):
    policy = policy_to_export(name)
    assert largest_difference(policy, SHIPPED / f"{name}.onnx", episodes=4, steps=100) < TOLERANCE


@pytest.mark.slow
@pytest.mark.parametrize("name", POLICIES)
def test_a_shipped_file_acts_as_its_policy_in_a_thousand_episodes(name):
    assert largest_difference(policy_to_export(name), SHIPPED / f"{name}.onnx", episodes=1000) < TOLERANCE


@pytest.mark.parametrize("name", POLICIES)
def test_a_shipped_file_is_what_the_command_makes(name, tmp_path):
    """Same operators, same metadata, same numbers; a design's last digits are the machine's."""
    export(policy_to_export(name), tmp_path / f"{name}.onnx", name)
    made, shipped = (onnx.load(folder / f"{name}.onnx") for folder in (tmp_path, SHIPPED))
    assert [node.op_type for node in made.graph.node] == [node.op_type for node in shipped.graph.node]
    about, told = ({p.key: p.value for p in model.metadata_props if p.key != "digest"} for model in (made, shipped))
    assert about == told
    for one, other in zip(made.graph.initializer, shipped.graph.initializer, strict=True):
        values, own = onnx.numpy_helper.to_array(one), onnx.numpy_helper.to_array(other)
        np.testing.assert_allclose(values, own, rtol=1e-6, atol=1e-9)


def test_what_is_shipped_is_listed():
    assert shipped_policies() == sorted(POLICIES)


def test_a_file_says_what_a_user_must_know():
    about = PolicyFile("ppo_surface").about
    assert [channel["name"] for channel in about["channels"]] == list(SENSORS["surface"].names)
    assert {channel["unit"] for channel in about["channels"]} == {"rad/s", "A", "V", "N m"}
    assert about["control_period"] == {"value": 0.1, "unit": "s"}
    assert about["speed_reference"] == {"low": 0.0, "high": 10.0, "unit": "rad/s"}
    assert about["drive"] == {"k_p": Rig().k_p, "k_i": Rig().k_i, "back_emf_share": 0.0}
    assert about["rig"]["k_1"] == Rig().k_1
    assert about["training"]["algorithm"] == "ppo"
    assert about["memory"] == [{"name": "frames", "width": 240, "type": "float32"}]
    times = {one["channel"]: one["time_constant"] for one in about["statistics"]}
    assert times == {"string_torque_mean": 10.0, "string_torque_deviation": 2.5}


def test_slew_limit_and_range_are_kept():
    policy = PolicyFile("z_torque")
    low, high = 0.01, 9.99
    values = dict.fromkeys(policy.inputs, 0.5)
    for reference, target, next_one in ((low, -50.0, 0.0), (high, 50.0, 10.0), (3.0, 50.0, 3.2), (3.0, 0.5, 2.8)):
        policy.reset()
        rate, found = policy.step({**values, "speed_reference": reference, "speed_target": target})
        assert abs(rate[0]) <= 2.0
        assert found[0] == pytest.approx(next_one, abs=1e-6)


def test_what_is_beyond_the_environments_clipping_is_clipped():
    policy, other = PolicyFile("ppo_surface"), PolicyFile("ppo_surface")
    values = dict.fromkeys(policy.inputs, 1.0)
    current = next(channel for channel in SENSORS["surface"].channels if channel.name == "current")
    edge = current.offset + LIMIT * current.scale
    assert policy.step({**values, "current": edge}) == other.step({**values, "current": 1e3})


def test_a_changed_file_is_refused(tmp_path):
    content = (SHIPPED / "lqg.onnx").read_bytes()
    at = content.index(b"drillrig_policy") - 2000  # amid the numbers
    (tmp_path / "lqg.onnx").write_bytes(content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :])
    with pytest.raises(ValueError, match=r"damaged|no ONNX file"):
        PolicyFile(tmp_path / "lqg.onnx")
    (tmp_path / "text.onnx").write_text("no policy")
    with pytest.raises(ValueError, match=r"text.onnx is no ONNX file"):
        PolicyFile(tmp_path / "text.onnx")
    with pytest.raises(ValueError, match=r"'lgq' is not known; did you mean lqg\?"):
        PolicyFile("lgq")
    with pytest.raises(ValueError, match=r"; `python -m agents\.export NAME` writes a file of a trained agent"):
        PolicyFile("ppo_unknown")


def test_a_file_of_somebody_else_is_refused(tmp_path):
    model = onnx.load(SHIPPED / "constant.onnx")
    del model.metadata_props[:]
    onnx.save(model, tmp_path / "other.onnx")
    with pytest.raises(ValueError, match="no policy of DrillRig"):
        PolicyFile(tmp_path / "other.onnx")
    model = onnx.load(SHIPPED / "constant.onnx")
    for item in model.metadata_props:
        item.value = json.dumps(2) if item.key == "format" else item.value
    onnx.save(model, tmp_path / "later.onnx")
    with pytest.raises(ValueError, match="has the format 2; allowed: up to 1"):
        PolicyFile(tmp_path / "later.onnx")
    assert NO_DIGEST.encode() not in (SHIPPED / "constant.onnx").read_bytes()


def test_what_cannot_be_a_file_is_refused(tmp_path):
    class Mine:
        def predict(self, observation, state=None, episode_start=None, deterministic=True):
            return np.zeros((len(observation), 1), np.float32), None

    for policy, message in (
        (JumpEase(), "told = .* is not allowed; allowed: nothing"),
        (Mine(), "allowed: a trained agent or a law that can be drawn"),
        (policy_to_export("soft_torque"), "allowed: Constant, JumpEaseEstimated, LQG, ZTorque"),
    ):
        with pytest.raises(ValueError, match=message):
            export(policy, tmp_path / "mine.onnx")
    assert not list(tmp_path.iterdir())


def test_values_that_are_no_numbers_are_refused():
    policy = PolicyFile("constant")
    values = dict.fromkeys(policy.inputs, 1.0)
    with pytest.raises(ValueError, match="top_speed = nan is not a finite number"):
        policy.step({**values, "top_speed": np.nan})
    policy = PolicyFile("z_torque")
    policy.step({name: [1.0, 2.0] for name in policy.inputs})
    with pytest.raises(ValueError, match=r"values of \[1, 2\] rigs"):
        policy.step(values)


def test_a_law_is_exported_for_a_rig_of_ones_own(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    FAST.to_toml(tmp_path / "fast.toml")
    assert main(["lqg", "--rig", "fast.toml", "--delay", "2", "--episodes", "2"]) == 0
    assert "lqg.onnx: " in capsys.readouterr().out
    about = PolicyFile("lqg.onnx").about
    assert (about["sensors"]["delay"], about["rig"]["J_1"]) == ([2, 2], FAST.J_1)
    assert about["control_period"]["value"] == pytest.approx(0.05)
    supervisor = Supervisor("lqg.onnx")
    assert supervisor.controller.period == about["control_period"]["value"]
    with pytest.raises(ValueError, match=r"control period of the fallback = 0.1 s is not allowed; allowed: 0.05"):
        Supervisor("lqg.onnx", Limits(fallback="z_torque"))


def test_a_trained_agent_is_for_what_it_was_trained_in(capsys):
    with pytest.raises(SystemExit):
        main(["ppo", "--delay", "2"])
    assert "ppo: what it is to be made for = delay is not allowed" in capsys.readouterr().err


@pytest.mark.parametrize("name", POLICIES)
def test_a_shipped_policy_describes_itself(name):
    text = Controller(name).describe()
    assert text.startswith(f"{name}: ")
    assert "drive: k_p " in text
    assert "wants each 0.1 s: " in text


@pytest.mark.parametrize("name", POLICIES)
def test_single_and_double_precision_are_alike(name):
    rng, one, other = np.random.default_rng(0), PolicyFile(name), PolicyFile(name)
    for _ in range(5):
        values = {channel: rng.uniform(0.0, 3.0, 4).astype(np.float32) for channel in one.inputs}
        doubles = {channel: value.astype(np.float64) for channel, value in values.items()}
        np.testing.assert_array_equal(one.step(values), other.step(doubles))
