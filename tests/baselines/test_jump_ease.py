import gymnasium as gym
import numpy as np
import pytest

import drillrig_env
from baselines import JumpEase, JumpEaseEstimated
from baselines.jump_ease import swing_of_a_ramp
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import suite
from drillrig_env.model import steady_state
from drillrig_env.stability import basin_depth
from tests.baselines.episode import BISTABLE, LOAD_STEP, play


@pytest.mark.parametrize("sensors", ["state", "encoders", "surface"])
def test_frees_a_bistable_rig_and_eases_back_to_the_target(sensors):
    info, references = play(JumpEase(sensors), BISTABLE)
    assert info["is_success"]
    assert references.max() > 4.79  # past the fold
    assert references[-1] == pytest.approx(3.2, abs=1e-4)


def test_eases_to_just_above_the_critical_speed_where_the_target_is_below():
    info, references = play(JumpEase(margin=0.2), {"normal_force": 20.0, "speed_target": 1.5, "start": "stick_slip"})
    assert references[-1] == pytest.approx(2.688 + 0.2, abs=1e-3)
    assert info["bit_speed"] == pytest.approx(references[-1], rel=0.02)


def test_comes_out_again_of_what_a_load_step_brought():
    assert play(JumpEase(), LOAD_STEP)[0]["is_success"]


def test_keeps_its_score_on_random_rigs():
    """A shipped heuristic must reach its score: guards physics, environment and scores together."""
    scores = score(run(JumpEase(), suite("default", 300)))
    below = scores["region"] == "below"
    assert scores["mitigated"][~below].mean() > 0.9
    assert scores["mitigated"][below].mean() < 0.05  # by nature: it stays above the critical speed
    assert scores["calm"].mean() > 0.95


def test_estimated_form_frees_a_rig_from_what_it_sees_alone():
    assert JumpEaseEstimated.privileged == ()
    info, references = play(JumpEaseEstimated(), BISTABLE)
    assert info["is_success"]
    assert references.max() > 4.8  # past the fold of 4.79 rad/s


@pytest.mark.parametrize("normal_force", [20.0, 30.0])
def test_estimated_friction_is_near_the_true_one_once_calm(normal_force):
    env = gym.make("DrillRig-v0", scenario="nominal")
    observation, _ = env.reset(
        seed=1, options={"normal_force": normal_force, "speed_target": 4.0, "start": "stick_slip"}
    )
    policy, state = JumpEaseEstimated(), None
    for _ in range(599):
        action, state = policy.predict(observation, state)
        observation, *_ = env.step(action)
    estimate = policy.estimates(state[0])[0]
    rig = drillrig_env.Rig()
    true = drillrig_env.Friction(normal_force)
    for speed in (0.01, 2.0, 4.0):
        assert estimate.torque(rig, speed)[0] == pytest.approx(
            true.torque(rig, speed), rel=0.1
        )  # seen ten times a second


def seen_calm(speed, target=3.0):
    """What a rig shows that turns evenly at `speed`."""
    values = {"bit_speed": speed, "top_speed": speed, "speed_reference": speed, "speed_target": target}
    return {name: np.array([value]) for name, value in values.items()}


FRICTION = {name: np.array([getattr(drillrig_env.Friction(20.0), name)]) for name in JumpEase.privileged}


@pytest.mark.parametrize(("of_basin", "slew_limit"), [(1e3, 2.0), (1e3, 0.5), (0.06, 2.0)])
def test_eases_down_at_the_safe_rate_and_never_faster_than_the_slew_limit(of_basin, slew_limit):
    policy = JumpEase(slew_limit=slew_limit, of_basin=of_basin)
    memory = np.zeros((1, policy.memory))
    lowered = 5.5 - policy.desired_reference(seen_calm(5.5), FRICTION, memory)[0]
    rig, friction = drillrig_env.Rig(), drillrig_env.Friction(20.0)
    safe = of_basin * basin_depth(rig, friction, 3.0) / swing_of_a_ramp(rig)
    assert lowered == pytest.approx(0.1 * min(safe, slew_limit), rel=1e-9)
    assert memory[0, 1] == 1.0


@pytest.mark.parametrize(("shake", "goes"), [(0.0, "down"), (0.07, "level"), (0.2, "up")])
def test_waits_between_shaking_and_calm(shake, goes):
    """A running oscillation of 7 % of the reference lets it neither rise nor ease; above 10 % it passes the fold."""
    policy, memory = JumpEase(), np.zeros((1, JumpEase.memory))
    memory[0, 0] = (5.5 * shake) ** 2 / np.exp(-0.1 / 2.5)  # what one more step without a twist rate leaves of it
    wanted = policy.desired_reference(seen_calm(5.5), FRICTION, memory)[0]
    fold = drillrig_env.stability.fold_speed(drillrig_env.Rig(), drillrig_env.Friction(20.0))
    assert wanted == pytest.approx({"level": 5.5, "up": max(1.1 * fold, 5.5)}.get(goes, wanted))
    assert (wanted < 5.5) == (goes == "down")
    assert memory[0, 1] == (goes == "down")


def test_goes_on_easing_up_to_the_limit_of_shaking_once_it_has_begun():
    policy = JumpEase()
    for easing, goes_on in ((0.0, False), (1.0, True)):
        memory = np.zeros((1, JumpEase.memory))
        memory[0, :2] = (5.5 * 0.07) ** 2 / np.exp(-0.1 / 2.5), easing
        assert (policy.desired_reference(seen_calm(5.5), FRICTION, memory)[0] < 5.5) == goes_on


def test_a_ramp_leaves_the_swing_behind_that_its_rate_is_chosen_by():
    """At the Hopf point nothing decays. A step is answered as a ramp is, differentiated: times the frequency."""
    rig = drillrig_env.Rig()
    friction = drillrig_env.Friction(10.0)
    border = drillrig_env.stability.critical_speed(rig, friction)
    run = drillrig_env.simulate(
        rig, friction, steady_state(rig, friction, border), [(0.0, border), (1.0, border + 1e-3)], duration=40.0
    )
    step = 0.5 * np.ptp(run.bit_speed[-300:])
    frequency = drillrig_env.stability.hopf_points(rig, friction)[1].frequency
    assert step / 1e-3 == pytest.approx(swing_of_a_ramp(rig) * frequency, rel=0.02)


def test_memory_begins_anew_with_an_episode():
    policy = JumpEase()
    policy.tell({"normal_force": 20.0, "mu_s": 0.5, "mu_k": 0.306, "v_b": 1.0})
    observation = np.zeros((1, len(policy.sensors.names)), np.float32)
    observation[0, policy.sensors.names.index("bit_speed")] = 1.0
    _, used = policy.predict(observation, None, np.array([True]))
    _, again = policy.predict(observation, used, np.array([True]))
    _, longer = policy.predict(observation, used, np.array([False]))
    np.testing.assert_array_equal(used[0], again[0])
    assert longer[0][0, 0] > used[0][0, 0]


def test_refuses_sensors_that_show_no_oscillation():
    with pytest.raises(ValueError, match=r"JumpEase reads one of \(bit_speed, top_speed\) or .*\(string_torque\)"):
        JumpEase(("top_speed", "speed_reference", "speed_target"))
    with pytest.raises(ValueError, match=r"JumpEaseEstimated reads twist_12.*'encoders' do not show.*do: state$"):
        JumpEaseEstimated("encoders")
    with pytest.raises(RuntimeError, match=r"told normal_force.*call tell"):
        JumpEase(("bit_speed", "top_speed", "speed_reference", "speed_target")).predict(np.zeros((1, 4), np.float32))
