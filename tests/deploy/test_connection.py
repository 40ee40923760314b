"""Whether a rig is what a policy was made for is looked at before anything turns."""

from types import SimpleNamespace

import pytest

from drillrig_env.deploy import Limits, Supervisor
from drillrig_env.deploy.connection import compare
from drillrig_env.rig import Rig

pytest.importorskip("onnxruntime")

UNITS = {"top_speed": "rad/s", "current": "A", "voltage": "V", "string_torque": "N m"}


def rig(channels=UNITS, period=0.1, **greeting):
    return SimpleNamespace(channels=dict(channels), period=period, greeting=greeting)


def test_a_rig_that_tells_little_may_be_any():
    assert compare(Supervisor("lqg"), rig()) == []
    own = {"drive": {"k_p": Rig().k_p}, "parameters": {"k_1": Rig().k_1}, "delay": 1}
    assert compare(Supervisor("lqg"), rig(**own)) == []


def test_what_differs_is_told():
    found = compare(Supervisor("lqg"), rig(drive={"k_p": 5.0, "k_i": "?"}, parameters={"k_1": 2.0}, delay=3))
    assert [line.partition(":")[0] for line in found] == ["drive", "rig", "instruments are 3 control steps late, "
                                                          "the policy is for 1 to 1"]  # fmt: skip
    assert "k_1 is 2, the policy is for 1.1175" in found[1]
    assert compare(Supervisor("lqg"), rig(delay="late")) == []


@pytest.mark.parametrize(
    ("policy", "limits", "channels", "missing"),
    [
        ("lqg", None, {**UNITS, "top_speed": "rpm"}, r"wants top_speed \(rad/s\); the rig offers top_speed \(rpm\)"),
        ("lqg", None, {"top_speed": "rad/s"}, r"wants current \(A\)"),
        ("ppo", None, UNITS, r"wants twist_12 \(rad\)"),
    ],
)
def test_a_channel_that_is_missing_or_in_another_unit_is_refused(policy, limits, channels, missing):
    with pytest.raises(ValueError, match=missing):
        compare(Supervisor(policy, limits), rig(channels))


def test_the_fallbacks_measurement_is_wanted_too():
    supervisor = Supervisor("constant", Limits(fallback="z_torque"))
    with pytest.raises(ValueError, match=r"constant wants string_torque \(N m\)"):
        compare(supervisor, rig({name: unit for name, unit in UNITS.items() if name != "string_torque"}))


def test_another_control_period_is_refused():
    with pytest.raises(ValueError, match=r"control period of the rig = 0.05 s is not allowed; allowed: 0.1"):
        compare(Supervisor("lqg"), rig(period=0.05))
