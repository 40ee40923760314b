"""Whatever is wrong with the measurements, the reference is held, then a simple law's, then ramped to a safe speed."""

import math
from dataclasses import replace

import numpy as np
import pytest

from baselines import ZTorque
from drillrig_env.deploy import Controller, Limits, State, Supervisor, shipped_policies
from drillrig_env.deploy.export import export
from drillrig_env.rig import Rig
from drillrig_env.scales import Scales
from drillrig_env.twin.dry_run import DryRig

pytest.importorskip("onnxruntime")

SOUND = {"top_speed": 2.0, "current": 1.2, "voltage": 2.0, "string_torque": 0.3}
LIMITS = Limits(hold_time=0.5, fallback_time=1.0, sound_time=0.3, frozen=10)


class Line:
    """Sound measurements that move a little, step by step, but for what a test puts in their place."""

    def __init__(self, policy="z_torque", limits=LIMITS, reference=2.0, target=3.0):
        self.supervisor = Supervisor(policy, limits)
        self.supervisor.start(reference, target, SOUND)
        self.steps, self.references = 0, [reference]

    def go(self, steps, ages=None, **changes):
        for _ in range(steps):
            self.steps += 1
            wave = 0.01 * math.sin(0.7 * self.steps)
            measured = {name: value + wave for name, value in SOUND.items()} | changes
            measured = {name: value for name, value in measured.items() if value != "absent"}
            self.references.append(self.supervisor.step(measured, 0.1 * self.steps, ages))
        return self.supervisor.state

    @property
    def last(self):
        return self.references[-1]

    @property
    def told(self):
        return [str(event) for event in self.supervisor.events.kept]


FAULTS = {
    "missing": ({"current": "absent"}, None, "current missing"),
    "none": ({"current": None}, None, "current missing"),
    "nan": ({"top_speed": math.nan}, None, "top_speed nan is no finite number"),
    "no character": (
        {"top_speed": "\ud800" * 99},
        None,
        r"top_speed '\ud800\ud800\ud800\ud800\ud800\ud800\ud is no finite",
    ),
    "huge": ({"top_speed": 10**400}, None, "is no finite number"),
    "text": ({"top_speed": "3.1"}, None, "top_speed '3.1' is no finite number"),
    "stale": ({}, {"voltage": 0.4}, "voltage stale: 0.4 s old, over 0.25 s"),
    "age unknown": ({}, {"voltage": math.nan}, "voltage stale"),
    "implausible": ({"string_torque": 50.0}, None, "string_torque implausible: 50, not within -2.7 to 3.3"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_held_then_taken_over_then_ramped_down(fault):
    changes, ages, reason = FAULTS[fault]
    line = Line()
    assert line.go(5) is State.NORMAL
    held = line.last
    assert line.go(5, ages, **changes) is State.HOLD
    assert line.references[-5:] == [held] * 5
    assert line.go(1, ages, **changes) is State.FALLBACK
    assert line.go(9, ages, **changes) is State.FALLBACK
    assert line.go(1, ages, **changes) is State.RAMP
    assert line.go(60, ages, **changes) is State.STOPPED
    assert line.last == LIMITS.safe_speed
    steps = np.diff(line.references)
    assert np.all(np.abs(steps) <= 0.2 + 1e-9)
    assert [e.kind for e in line.supervisor.events.kept if e.kind != "limit"] == [
        "start",
        "fault",
        "fault",
        "ramp",
        "stopped",
    ]
    assert reason in line.told[1]
    assert line.go(30) is State.STOPPED  # sound again: it waits for the operator
    line.supervisor.restart(SOUND)
    assert line.go(5) is State.NORMAL
    assert line.last > LIMITS.safe_speed


def test_a_frozen_instrument_is_found():
    line = Line()
    assert line.go(10, current=1.234) is State.NORMAL
    assert line.go(1, current=1.234) is State.HOLD
    assert "current frozen: 1.234 for 10 control steps" in line.told[-1]


def test_a_short_fault_is_over_without_a_bump():
    line = Line("ppo_surface")
    line.go(8)
    mean = line.supervisor.controller.statistics.values["string_torque_mean"]
    assert line.go(2, current=None) is State.HOLD
    assert line.go(2) is State.HOLD  # not yet sound for long enough
    assert line.go(2) is State.NORMAL
    assert abs(line.references[-1] - line.references[-3]) <= 0.4 + 1e-9
    assert line.supervisor.controller.statistics.values["string_torque_mean"] == pytest.approx(mean, abs=0.01)
    assert "no fault for 0.3 s" in " ".join(line.told)


def test_the_fallback_law_gives_way_to_the_torque():
    line = Line("lqg", Limits(fallback="z_torque", hold_time=0.1, fallback_time=100.0), reference=3.0)
    assert line.go(4, current=None) is State.FALLBACK
    line.go(40, current=None)
    level = line.last
    line.go(2, current=None, string_torque=0.9)
    assert line.last < level - 0.1
    line.go(20, current=None, string_torque=None)  # its own measurement fails too: the target
    assert line.last == pytest.approx(3.0)
    assert line.supervisor.state is State.FALLBACK


def test_a_late_step_is_a_fault():
    line = Line()
    line.go(5)
    line.steps += 5
    assert line.go(1) is State.HOLD
    assert "control step late: 0.6 s after the last one, over 0.3 s" in line.told[-1]


def test_an_early_step_is_a_fault_and_moves_nothing():
    line = Line("constant")
    line.go(1)
    line.supervisor.step(SOUND, 0.1 * line.steps + 0.02)
    assert line.supervisor.state is State.HOLD
    assert line.supervisor.reference == line.last
    assert "control step early: 0.02 s after the last one, below 0.05 s" in line.told[-1]


def test_a_policy_that_fails_is_a_fault(monkeypatch):
    line = Line()
    line.go(3)
    monkeypatch.setattr(line.supervisor.controller.file, "step", lambda values: 1 / 0)
    assert line.go(1) is State.HOLD
    assert line.references[-1] == line.references[-2]
    assert "the policy failed: division by zero" in line.told[-1]


def test_range_and_rate_are_kept():
    line = Line("constant", Limits(highest_reference=2.5, lowest_reference=1.5, rate=0.5), reference=1.0, target=3.0)
    line.go(60)
    assert line.last == 2.5
    assert np.max(np.abs(np.diff(line.references))) <= 0.05 + 1e-12
    line.supervisor.target = 1.2
    line.go(60)
    assert line.last == 1.5
    assert any("the policy wants" in told for told in line.told)
    assert any("target: 1.2 rad/s" in told for told in line.told)


def test_an_overload_stops_the_rise_and_then_brings_the_rig_down():
    line = Line("constant", Limits(current=2.0, overload_time=1.0), reference=1.5, target=5.0)
    line.go(3)
    level = line.last
    assert line.go(5, current=2.5) is State.NORMAL
    assert line.last == level
    assert line.go(6, current=2.5) is State.RAMP
    assert "current = 2.5 A is above 2 A for 1 s" in line.told[-1]
    line = Line("constant", Limits(torque=1.0, overload_time=1.0), reference=1.5, target=5.0)
    for _ in range(10):  # peaks of stick-slip: no ramp
        line.go(5, string_torque=1.2)
        assert line.go(5) is State.NORMAL


def test_a_top_speed_above_its_limit_brings_the_rig_down_at_once():
    line = Line("constant", Limits(top_speed=5.0))
    assert line.go(1, top_speed=5.5) is State.RAMP
    assert "top_speed = 5.5 rad/s is above 5 rad/s" in line.told[-1]


def test_the_operator_stops_and_starts():
    line = Line("constant")
    line.go(10)
    line.supervisor.stop("somebody opens the door")
    assert line.go(1) is State.RAMP
    line.go(100)
    assert (line.supervisor.state, line.last) == (State.STOPPED, 0.0)
    assert "stop: somebody opens the door" in " ".join(line.told)
    line.supervisor.restart(SOUND)
    line.go(40)
    assert line.last == pytest.approx(3.0)


def test_a_restart_in_a_fault_is_refused():
    line = Line()
    line.supervisor.stop()
    line.go(5, current=None)
    with pytest.raises(ValueError, match="restart is not allowed: current missing"):
        line.supervisor.restart(SOUND)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Supervisor(Controller("lqg", units={"top_speed": "rpm"})), "units of the controller"),
        (lambda: Supervisor("lqg").step(SOUND, 0.0), "step before start"),
        (lambda: Line().supervisor.step(SOUND, -1.0), "time = -1.0 s is not allowed; allowed: >= 0"),
        (lambda: Line().supervisor.step(SOUND, math.nan), "time = nan s is not allowed"),
        (lambda: Line().supervisor.stop(speed=-1.0), "speed = -1.0 rad/s is not allowed"),
        (lambda: Limits(rate=0.0), "rate = 0.0 rad/s.2 is not allowed; allowed: > 0"),
        (lambda: Limits(lowest_reference=11.0), "lowest_reference = 11.0 rad/s is not allowed; allowed: < high"),
        (lambda: Limits(safe_speed=20.0), "safe_speed = 20.0 rad/s"),
        (lambda: Limits(plausible={"current": (3.0, 1.0)}), "plausible current = "),
        (lambda: Limits(fallback=""), "fallback = '' is not allowed; allowed: constant, z_torque, or"),
        (lambda: Supervisor("lqg", Limits(fallback="ppo")), "fallback = 'ppo' is not allowed; allowed: constant, z_t"),
        (lambda: Supervisor("lqg", Limits(fallback="z_toque")), r"'z_toque' is not known; did you mean z_torque\?"),
    ],
)
def test_what_makes_no_sense_is_named(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("policy", shipped_policies())
def test_limits_that_are_not_given_are_those_of_the_policys_rig(policy):
    assert Supervisor(policy).limits == Limits()  # the chapter's


def test_limits_grow_with_the_rig(tmp_path):
    slow, strong = 4.0, 9.0  # the chapter's rig with time running four times slower, and torques nine times as large
    chapter = Rig()
    scaled = {name: getattr(chapter, name) * strong for name in ("k_1", "k_2")}
    scaled |= {name: getattr(chapter, name) * strong * slow for name in ("d_1", "d_2")}
    scaled |= {name: getattr(chapter, name) * strong * slow**2 for name in ("J_1", "J_2", "J_3")}
    export(ZTorque(sensors="surface", rig=replace(chapter, **scaled)), tmp_path / "law.onnx")
    limits = Supervisor(tmp_path / "law.onnx").limits
    assert limits.highest_reference == pytest.approx(10.0 / slow)
    assert limits.rate == pytest.approx(2.0 / slow**2)
    assert limits.ramp == pytest.approx(0.5 / slow**2, rel=5e-3)
    assert (limits.stale, limits.hold_time, limits.fallback_time) == (1.0, 4.0, 40.0)
    assert limits.frozen == 20
    assert (limits.top_speed, limits.safe_speed) == (3.0, 0.25)
    scales = Scales.of(replace(chapter, **scaled), limits.highest_reference)
    assert limits.current == pytest.approx(1.3 * scales.current + 2.7 * scales.current_swing, rel=5e-3)
    assert limits.torque == pytest.approx(0.3 * scales.load + 1.2 * scales.torque, rel=5e-3)
    about = Supervisor(tmp_path / "law.onnx").controller.file.about
    assert Limits.for_policy(about, rate=0.01, fallback="z_torque").rate == 0.01


@pytest.mark.parametrize("rig", range(4))
def test_sound_instruments_raise_no_alarm(rig):
    bench = DryRig(rig)
    supervisor = Supervisor("lqg")
    supervisor.start(bench.reference, bench.target, bench.measure())
    for step in range(400):
        bench.command(supervisor.step(bench.measure(), 0.1 * (step + 1)))
    assert supervisor.state is State.NORMAL
    assert [event for event in supervisor.events.kept if event.kind not in ("start", "limit")] == []
