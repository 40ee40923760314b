"""The controller sees what the environment shows, begins without a bump, and takes nothing that it does not know."""

import subprocess
import sys
from copy import deepcopy

import numpy as np
import pytest

from drillrig_env.deploy import Controller
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.kernel import scratch, step_episodes
from drillrig_env.seeds import VALIDATION_SEEDS
from drillrig_env.stepper.ladder import SAMPLES

pytest.importorskip("onnxruntime")

MEASURED = {"top_speed": 2.0, "current": 1.2, "voltage": 2.0, "string_torque": 0.3}


def step_with_samples(core, action):
    """One control step of one rig, and the samples of the bit speed within it."""
    memory, observations = scratch(), np.empty_like(core.observations)
    arguments = list(core._arguments(slice(None), np.full((1, 1), action, np.float32), observations))
    arguments[-1] = memory
    assert step_episodes(*arguments) == 0
    core.observations = observations
    return memory["work"]["speed_samples"][0, :SAMPLES].tolist()


@pytest.mark.parametrize(("policy", "sensors"), [("ppo", "state"), ("z_torque", "surface"), ("ppo_surface", "surface")])
def test_running_means_and_references_are_those_of_the_environment(policy, sensors):
    core = EpisodeBatch(1, sensors=sensors, noise=0.0, delay=0)
    core.reset(np.arange(1), first_uniforms(VALIDATION_SEEDS.start + 3, 1))
    controller = Controller(policy)
    episode = core.episodes[0]
    known = {"string_torque_mean": "torque_mean", "bit_speed_mean": "mean"}
    roots = {"string_torque_deviation": "torque_variance", "bit_speed_deviation": "variance"}

    def statistics():
        means = {channel: float(episode[name]) for channel, name in known.items()}
        return {**means, **{channel: float(np.sqrt(episode[name])) for channel, name in roots.items()}}

    asked = {one["channel"] for one in controller.statistics.asked}

    def measured():
        names = ("twist_12", "twist_23", "bit_speed", "collar_speed", "top_speed", "current", "speed_error_integral")
        values = dict(zip(names, episode["state"][:7].tolist(), strict=True))
        values |= {"voltage": float(episode["voltage"]), "string_torque": float(episode["string_torque"])}
        return {name: values[name] for name in controller.channels}

    begin = {name: value for name, value in statistics().items() if name in asked}
    controller.start(float(episode["speed_reference"]), float(episode["speed_target"]), {**measured(), **begin})
    values = measured()
    for _ in range(150):
        reference = controller.step(values)
        action = (reference - float(episode["speed_reference"])) / (controller.slew_limit * controller.period)
        samples = step_with_samples(core, action)
        values = measured()
        if "bit_speed" in values:
            values["bit_speed"] = samples
        assert reference == pytest.approx(float(episode["speed_reference"]), abs=1e-7)
        seen = deepcopy(controller.statistics)
        seen.update({name: np.atleast_1d(value).tolist() for name, value in values.items()})
        for name, value in seen.values.items():
            assert value == pytest.approx(statistics()[name], rel=1e-12, abs=1e-12)


def test_it_starts_without_a_bump_from_any_reference():
    for reference in (0.0, 0.7, 3.0, 10.0, 12.5, -0.4):
        controller = Controller("lqg")
        controller.start(reference, 4.0, MEASURED)
        assert controller.reference == reference
        assert abs(controller.step(MEASURED) - reference) <= 0.2 + 1e-9


def test_a_reference_that_somebody_else_has_moved_is_taken_up():
    controller = Controller("constant")
    controller.start(1.0, 4.0, MEASURED)
    assert controller.step(MEASURED) == pytest.approx(1.2)
    assert controller.step(MEASURED, reference=3.0) == pytest.approx(3.2)


def test_units_are_turned_into_those_of_the_policy():
    rpm = 60.0 / (2.0 * np.pi)
    one, other = Controller("z_torque"), Controller(
        "z_torque", units={"top_speed": "rpm", "current": "mA", "speed_reference": "1/min", "speed_target": "rpm"}
    )  # fmt: skip
    one.start(2.0, 3.0, MEASURED)
    turned = {**MEASURED, "top_speed": MEASURED["top_speed"] * rpm, "current": 1e3 * MEASURED["current"]}
    other.start(2.0 * rpm, 3.0 * rpm, turned)
    for _ in range(5):
        assert other.step(turned) == pytest.approx(one.step(MEASURED) * rpm, rel=1e-6)
    assert other.target == pytest.approx(3.0 * rpm)
    assert "top_speed (rpm)" in other.wants


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda c: Controller("z_torque", units={"top_speed": "A"}),
            "unit of top_speed = 'A' is not allowed",
        ),
        (lambda c: Controller("z_torque", units={"topspeed": "rpm"}), r"'topspeed'; did you mean top_speed\?"),
        (lambda c: c.step(MEASURED), "has not been started"),
        (lambda c: c.start(1.0, 0.0, MEASURED), "speed_target = 0.0 rad/s is not allowed; allowed: > 0 and <= 10"),
        (lambda c: c.start(np.nan, 2.0, MEASURED), "speed_reference = nan rad/s is not allowed"),
        (lambda c: c.start(1.0, 2.0, {"top_speed": 1.0}), r"current \(A\) is missing; it wants top_speed \(rad/s\)"),
        (lambda c: c.start(1.0, 2.0, {**MEASURED, "curent": 1.0}), r"'curent'; did you mean current\?"),
        (lambda c: c.start(1.0, 2.0, {**MEASURED, "current": None}), "current = None A is not allowed; allowed: a fin"),
        (lambda c: c.start(1.0, 2.0, {**MEASURED, "current": "1.2A"}), "current = 1.2A A is not allowed"),
    ],
)
def test_what_it_cannot_take_is_named(make, message):
    with pytest.raises(ValueError, match=message):
        make(Controller("z_torque"))


def test_it_runs_where_neither_torch_nor_sb3_nor_numba_can_be_imported():
    program = """
import sys
for name in ("torch", "stable_baselines3", "numba", "scipy", "onnx", "pandas"):
    sys.modules[name] = None  # any import of it fails
from drillrig_env.deploy import Controller
controller = Controller("ppo_surface")
measured = {"top_speed": 3.1, "current": 1.2, "voltage": 2.0, "string_torque": 0.3}
controller.start(3.0, 3.0, measured)
print(controller.step(measured))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert 2.8 <= float(done.stdout) <= 3.2
