"""A drive that limits its current, or whose voltage is off: against the event-split reference, and in closed form."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

from benchmarks.any_rig import draw
from drillrig_env import Drive, Friction, Rig, simulate
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.friction.tilt import Tilt
from drillrig_env.model import armature_voltage, steady_state
from drillrig_env.stepper.batch import simulate_batch
from drillrig_env.stepper.tables import build_tables
from tests.rigs import FIELD, scaled

pytestmark = pytest.mark.usefixtures("coarser_radau")

LIMITED = Drive(3.0, 1.0, current_limit=1.4)
STICK_SLIP = {"friction": Friction(20.0), "speed_reference": 2.0, "duration": 6.0, "sample_period": 0.05}


def share_limited(run):
    """How many samples of a run the drive limits its current in."""
    beside = run.voltage - run.drive.voltage_offset - run.rig.eta * run.rig.K_E * run.top_speed
    return np.mean(np.abs(np.abs(beside) - run.drive.room(run.rig)) < 1e-9)


@pytest.mark.parametrize(
    ("rig", "drive"),
    [
        (Rig(), LIMITED),
        (Rig(), Drive(3.0, 1.0, current_limit=1.15, voltage_offset=-0.1)),
        (Rig(), Drive(0.3, 0.3, 0.5, current_limit=1.3)),
        (Rig(T_r2=0.1), Drive(0.3, 0.3, 0.5, current_limit=1.2, voltage_offset=0.1)),
        (Rig(T_r2=0.1, k_p=0.2), LIMITED),
    ],
)
def test_a_limited_drive_is_the_event_split_solution(rig, drive):
    run = {**STICK_SLIP, "duration": 3.0}
    fast, exact = (simulate(rig, drive=drive, method=method, **run) for method in ("fast", "radau"))
    np.testing.assert_allclose(fast.state, exact.state, atol=1e-7)
    assert share_limited(exact) > 0.1
    assert fast.current.max() < drive.current_limit + max(drive.voltage_offset, 0.0) / rig.R + 1e-9


def test_a_reference_that_steps_drives_it_into_both_limits():
    steps = {"speed_reference": [(0, 6.0), (2, 0.0), (4, 3.0)], "duration": 6.0, "friction": Friction(3.0)}
    drive = Drive(3.0, 1.0, current_limit=2.0)
    fast, exact = (simulate(Rig(), drive=drive, sample_period=0.02, method=way, **steps) for way in ("fast", "radau"))
    np.testing.assert_allclose(fast.state, exact.state, atol=1e-7)
    assert fast.current.max() == pytest.approx(2.0, abs=1e-3)
    assert fast.current.min() == pytest.approx(-2.0, abs=1e-3)


def test_so_does_the_chapters_way():
    arguments = {**STICK_SLIP, "duration": 2.0, "drive": Drive(3.0, 1.0, current_limit=1.2, voltage_offset=0.2)}
    fast, plain = (simulate(Rig(), method=method, **arguments) for method in ("fast", "vode"))
    np.testing.assert_allclose(fast.state[:, 2:5], plain.state[:, 2:5], atol=3e-5)


def test_so_are_rigs_of_all_kinds():
    rng, limited = np.random.default_rng(4), 0
    for case in draw(6, seed=6):
        rig = replace(case.rig, C_2=0.1 * case.rig.k_2 / (1.0 + case.speed_reference))
        usual = float(steady_state(rig, case.friction.single(), max(case.speed_reference, 0.1))[5])
        drive = Drive(rig.k_p + 0.01, rig.k_i, current_limit=abs(usual) * rng.uniform(0.3, 1.5) + 1e-3)
        arguments = {"friction": case.friction, "speed_reference": case.speed_reference, "duration": 2.0}
        fast, exact = (
            simulate(rig, initial_state=case.state, sample_period=0.1, method=method, drive=drive, **arguments)
            for method in ("fast", "radau")
        )
        limited += share_limited(exact) > 0.0
        scale = max(1.0, np.abs(exact.state[:, 2:5]).max())
        np.testing.assert_allclose(fast.state[:, 2:5], exact.state[:, 2:5], atol=1e-6 * scale)
    assert limited > 3


def test_a_limit_that_is_never_reached_changes_no_bit():
    far = replace(LIMITED, current_limit=1e4)
    runs = [simulate(drive=drive, **STICK_SLIP).state for drive in (None, Drive(3.0, 1.0), far)]
    np.testing.assert_array_equal(runs[1], runs[0])
    np.testing.assert_array_equal(runs[2], runs[0])
    assert len(build_tables([Rig()], 0.1, drive=far).ladders) == 3


def test_under_a_torque_that_is_too_large_it_stalls():
    rig = Rig()
    run = simulate(rig, Friction(60.0), speed_reference=2.0, duration=60.0, drive=Drive(3.0, 1.0, current_limit=1.2))
    end = run.state[-1]
    np.testing.assert_allclose(end[2:5], 0.0, atol=1e-3)
    assert end[5] == pytest.approx(1.2, abs=1e-9)
    assert run.voltage[-1] == pytest.approx(rig.R * 1.2 + rig.eta * rig.K_E * end[4], rel=1e-12)
    assert run.torque_into_string[-1] == pytest.approx(rig.eta * (rig.K_T * 1.2 - rig.T_f), abs=1e-3)
    assert rig.k_i * end[6] == pytest.approx(run.voltage[-1], abs=1e-3)  # it has not wound up
    assert simulate(rig, Friction(60.0), speed_reference=2.0, duration=60.0).bit_speed.max() > 5.0  # without a limit


def test_it_is_over_its_limit_soon_after_the_load_has_gone():
    load = [(0, 60.0), (60, 3.0)]
    calm = {"speed_reference": 2.0, "duration": 75.0, "normal_force": load}
    run = simulate(Rig(), Friction(), drive=Drive(3.0, 1.0, current_limit=1.2), **calm)
    after = run.top_speed[run.time > 62.0]
    assert after.max() < 2.4
    assert abs(after[-1] - 2.0) < 0.05


def test_an_offset_of_the_voltage_moves_the_integrator_and_nothing_else():
    drive = Drive(3.0, 1.0, voltage_offset=0.4)
    start = steady_state(Rig(), Friction(5.0), 4.0)
    start[6] -= 0.4
    run = simulate(Rig(), Friction(5.0), start, 4.0, 5.0, drive=drive)
    np.testing.assert_allclose(run.state, np.broadcast_to(start, run.state.shape), atol=1e-9)
    np.testing.assert_allclose(
        run.voltage, simulate(Rig(), Friction(5.0), start + 0.4 * np.eye(7)[6], 4.0, 5.0).voltage
    )


@pytest.mark.parametrize(("time", "torque"), [(2.0**-3, 2.0**20), (2.0**10, 2.0**-7)])
def test_other_powers_of_two_change_no_bit(time, torque):
    def speeds(s, tau):
        rig = scaled(time=tau, torque=s, rig=Rig(T_r2=0.05))
        drive = Drive(rig.k_p, rig.k_i, 0.5, current_limit=1.3, voltage_offset=0.1)
        return (
            simulate(rig, Friction(20.0, v_b=tau), None, 2.0 / tau, 4.0 * tau, 0.05 * tau, drive=drive).state[:, 2:5]
            * tau
        )

    np.testing.assert_array_equal(speeds(torque, time), speeds(1.0, 1.0))


def test_each_rig_of_a_batch_comes_out_as_alone():
    forces = np.array([3.0, 20.0, 35.0])
    batch = simulate_batch(Rig(), Friction(forces), speed_reference=2.0, duration=5.0, drive=LIMITED, threads=2)
    for states, force in zip(batch, forces, strict=True):
        alone = simulate(Rig(), Friction(force), speed_reference=2.0, duration=5.0, sample_period=0.1, drive=LIMITED)
        np.testing.assert_array_equal(states, alone.state)


@pytest.mark.parametrize("rigs", [None, [Rig(), Rig(T_r2=0.1), Rig(K_E=0.08, R=0.4)]])
def test_the_environment_tells_what_voltage_is_applied(rigs):
    drive = replace(LIMITED, voltage_offset=0.05, back_emf_share=0.3)
    scenario = "default" if rigs is None else {"rigs": rigs}
    core, limited = EpisodeBatch(3, scenario=scenario, drive=drive), 0
    core.reset(np.arange(3), first_uniforms(0, 3), {"normal_force": 25.0, "speed_target": 2.0, "start": "stick_slip"})
    for _ in range(60):
        before = core.episodes["state"][:, :7].copy()
        core.step(np.full((3, 1), 0.1, dtype=np.float32))
        for one, state in zip(core.episodes, before, strict=True):
            rig, reference = (rigs or [Rig()])[one["rig"]], float(one["speed_reference"])
            own = drive.on(Rig()) if rigs else drive
            friction = Friction(*(float(one[name]) for name in ("normal_force", "mu_s", "mu_k", "v_b")))
            after = simulate(rig, friction, state, reference, 0.1, 0.1, drive=own)
            np.testing.assert_array_equal(one["state"][:7], after.state[-1])
            assert one["voltage"] == pytest.approx(after.voltage[-1], abs=1e-12)
            limited += one["voltage"] != pytest.approx(
                armature_voltage(rig, replace(own, current_limit=None), reference, *one["state"][[4, 6]])
            )
    assert limited > 10


def test_every_form_of_the_environment_has_it():
    options = {"normal_force": 30.0, "speed_target": 2.0, "start": "rest"}
    arguments = {"drive": {"k_p": 3.0, "k_i": 1.0, "current_limit": 1.2}, "sensors": "state", "noise": 0.0}
    one, many = gym.make("DrillRig-v0", **arguments), gym.make_vec("DrillRig-v0", num_envs=2, **arguments)
    one.reset(seed=3, options=options)
    many.reset(seed=3, options=options)
    for _ in range(100):
        seen, *_ = one.step(np.array([0.8], dtype=np.float32))
        both, *_ = many.step(np.full((2, 1), 0.8, dtype=np.float32))
        np.testing.assert_array_equal(both[0], seen)
    assert one.unwrapped.core.episodes["state"][0, 5] == pytest.approx(1.2, abs=1e-6)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Drive(3.0, 1.0, current_limit=0.0), r"current_limit = 0\.0 A is not allowed; allowed: > 0 A"),
        (
            lambda: Drive(0.0, 1.0, current_limit=1.0),
            r"k_p = 0\.0 V s/rad is not allowed; allowed: > 0 with a current_limit",
        ),
        (lambda: Drive(3.0, 1.0, voltage_offset=np.nan), r"voltage_offset = nan V"),
        (
            lambda: (
                simulate(FIELD, drive=(38e3, 1e5, 0.0))
                and simulate(FIELD, drive={"k_p": 38e3, "k_i": 1e5, "current_limit": 3e4})
            ),
            "current_limit = 30000.0 A is not allowed; allowed: none on a rig that loses so little",
        ),
        (
            lambda: simulate(drive=LIMITED, tilt=Tilt(0.2)),
            r"current_limit = 1\.4 A is not allowed; allowed: none where the disc is tilted",
        ),
        (lambda: gym.make("DrillRig-v0", drive=LIMITED, scenario={"tilt": Tilt(0.2)}), "none where the disc is tilted"),
    ],
)
def test_what_is_not_allowed_is_named(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_files_keep_it():
    drive = replace(LIMITED, voltage_offset=0.1)
    assert Drive.of(drive.as_dict()) == drive
    assert "current_limit" not in Drive(3.0, 1.0).as_dict()
    assert drive.on(Rig()) == drive
    assert replace(drive, back_emf_share=0.5).on(Rig()).current_limit == 1.4
