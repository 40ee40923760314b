import numpy as np
import pytest

from baselines.feed_forward_start import FeedForwardStart
from baselines.startup_plan import Haste, startup_plan
from baselines.tune import tuning_suite
from drillrig_env import Friction, Rig, simulate
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.model import frictionless_state
from tests.baselines.episode import BISTABLE, UNSTABLE, play

HASTE = Haste(acceleration=1.4, build_up=1.0)


def stuck(rig, torque):
    """The drive at rest with the string wound up to a torque that the stuck bit bears."""
    x = frictionless_state(rig, 0.0)
    x[0], x[1] = -torque / rig.k_1, -torque / rig.k_2
    x[5] += torque / (rig.eta * rig.K_T)
    x[6] = rig.R * x[5] / rig.k_i
    return x


@pytest.mark.parametrize(("normal_force", "speed"), [(10.0, 2.5), (10.0, 4.0), (20.0, 3.2)])
def test_the_plan_inverts_the_model(normal_force, speed):
    """The rig driven by the planned references, each held for 0.1 s, follows the planned bit speed."""
    rig, friction = Rig(), Friction(normal_force)
    torque = 0.6 * friction.torque(rig, rig.omega_s)
    plan = startup_plan(rig, (normal_force, 0.5, 0.306, 1.0), torque, 0.0, speed, HASTE)
    schedule = [(0.1 * i, max(float(value), 0.0)) for i, value in enumerate(plan.references)]
    driven = simulate(rig, friction, stuck(rig, torque), schedule, duration=plan.time[-1], sample_period=0.01)
    planned = np.interp(driven.time, plan.time, plan.bit_speed)
    assert planned[-1] == pytest.approx(speed, abs=0.01)
    assert np.abs(driven.bit_speed - planned).max() < 0.02 * speed


def test_the_plan_is_smooth_and_within_the_slew_limit():
    plan = startup_plan(Rig(), (15.0, 0.5, 0.306, 1.0), 0.2, 0.02, 3.5, HASTE)
    assert np.all(np.diff(plan.bit_speed) >= 0.0)
    assert np.abs(np.diff(plan.references)).max() < 0.21
    assert plan.references[0] == pytest.approx(0.0, abs=0.01)  # as the stop left it
    assert plan.references[-1] == pytest.approx(3.5, rel=0.05)  # the speed loop is still settling


@pytest.mark.parametrize("sensors", ["state", "surface"])
def test_frees_a_bistable_rig(sensors):
    info, references = play(FeedForwardStart(sensors), BISTABLE)
    assert references.min() == 0.0  # it stops first
    assert info["is_success"]


def test_starts_a_rig_from_rest_without_stick_slip():
    options = {"normal_force": 15.0, "speed_target": 3.2, "start": "rest"}
    info, references = play(FeedForwardStart(), options)
    assert info["is_success"]
    late = references[np.argmax(references > 2.0) :]
    assert late.min() > 2.0  # the first start is the last


def test_stays_above_the_critical_speed_where_the_target_is_below():
    info, references = play(FeedForwardStart(margin=0.2), {**UNSTABLE, "normal_force": 10.0, "speed_target": 1.2})
    assert references[-1] == pytest.approx(1.9949 + 0.2, abs=1e-3)
    assert info["bit_speed"] == pytest.approx(references[-1], rel=0.05)


def test_reaches_its_mark_on_random_rigs_above_the_critical_speed():
    scores = score(run(FeedForwardStart(), tuning_suite("default", 150, 590_000_000)))
    below = scores["region"] == "below"
    assert scores["mitigated"][~below].mean() > 0.85
    assert scores["mitigated"][below].mean() < 0.05  # by nature: open-loop, it stays above


def test_refuses_sensors_without_torque():
    with pytest.raises(ValueError, match=r"FeedForwardStart reads one of .*string_torque.* would do: state, surface"):
        FeedForwardStart("encoders")


@pytest.mark.parametrize("start", ["steady", "rest"])
def test_a_rig_without_load_is_brought_to_its_target_and_left_alone(start):
    info, references = play(
        FeedForwardStart("surface"), {"normal_force": 0.0, "speed_target": 3.0, "start": start, "load_steps": []}
    )
    assert info["is_success"]
    assert references[-1] == pytest.approx(3.0, abs=0.05)
