"""Dry friction T_r2(x_4) of disc 2: where it sticks and turns backwards, against the event-split reference."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.any_rig import draw
from drillrig_env import Friction, Rig, simulate
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.friction.tilt import Tilt
from drillrig_env.model import (
    dissipated_power,
    frictionless_state,
    motor_power,
    stored_energy,
    torque_on_collars,
    wound_up,
)
from drillrig_env.stability.limit_cycle import stick_slip_orbit
from drillrig_env.stepper.batch import simulate_batch
from drillrig_env.stepper.ladder import SAMPLES, UNITS, from_equilibrium
from drillrig_env.stepper.propagator import advance
from drillrig_env.stepper.tables import build_tables
from drillrig_env.stepper.workspace import workspace
from tests.rigs import FIELD, scaled

pytestmark = pytest.mark.usefixtures("coarser_radau")

STICK_SLIP = {"friction": Friction(20.0), "speed_reference": 2.0, "duration": 6.0, "sample_period": 0.05}
SWINGING = (0.3, 1.5, 0.5, -2.0, 0.0, 0.5, 0.0)
"""A state whose disc 2 turns backwards, and swings to and fro before it comes to rest."""


def close(rig, atol=1e-7, **arguments):
    fast, exact = (simulate(rig, method=method, **arguments) for method in ("fast", "radau"))
    np.testing.assert_allclose(fast.state[:, 2:5], exact.state[:, 2:5], atol=atol)
    return fast


@pytest.mark.parametrize("torque", [0.02, 0.1, 0.4, 2.0])
def test_a_disc_2_that_sticks_is_the_event_split_solution(torque):
    run = close(Rig(T_r2=torque), **STICK_SLIP)
    assert np.mean(np.abs(run.collar_speed[1:]) < 1e-3) > 0.005


@pytest.mark.parametrize(("torque", "omega_s"), [(0.01, 1e-3), (0.05, 1e-3), (0.2, 1e-6), (0.1, 0.3)])
def test_one_that_swings_to_and_fro_is_too(torque, omega_s):
    rig = Rig(T_r2=torque, omega_s=omega_s)
    run = close(rig, friction=Friction(3.0), speed_reference=0.0, initial_state=SWINGING, duration=4.0)
    assert run.collar_speed.min() < -1.9
    assert np.abs(run.collar_speed).min() < omega_s


@pytest.mark.parametrize("rig", [Rig(T_r2=0.1), Rig(T_r2=0.4, omega_s=0.02)])
def test_so_is_one_beside_a_tilted_disc(rig):
    run = close(rig, 1e-6, **STICK_SLIP, tilt=Tilt(0.4, 3, 0.7))
    assert np.abs(run.collar_speed[1:]).min() < rig.omega_s


def test_the_chapters_way_sees_the_same_law():
    rig = Rig(T_r2=0.1)
    arguments = {"friction": Friction(3.0), "speed_reference": 0.0, "initial_state": SWINGING, "duration": 2.0}
    fast, plain = (simulate(rig, method=method, **arguments) for method in ("fast", "vode"))
    np.testing.assert_allclose(fast.state[:, 2:5], plain.state[:, 2:5], atol=3e-5)


@pytest.mark.slow
def test_so_are_rigs_of_all_kinds():
    rng = np.random.default_rng(3)
    for case in draw(12, seed=5):
        torque = float(np.max(np.abs(case.friction.torque(case.rig, 1.0)))) * 10.0 ** rng.uniform(-1.5, 0.7) + 1e-3
        arguments = {"friction": case.friction, "speed_reference": case.speed_reference, "duration": 2.0}
        rig = replace(case.rig, T_r2=torque)
        fast, exact = (
            simulate(rig, initial_state=case.state, sample_period=0.1, method=method, **arguments)
            for method in ("fast", "radau")
        )
        scale = max(1.0, np.abs(exact.state[:, 2:5]).max())
        np.testing.assert_allclose(fast.state[:, 2:5], exact.state[:, 2:5], atol=1e-6 * scale)


def test_so_is_a_field_string():
    rig = replace(FIELD, T_r2=2000.0, C_1=50.0)
    friction = Friction(9000.0, 1.0, 0.6, 0.2)
    run = close(rig, 1e-6, friction=friction, speed_reference=2.0, duration=20.0, sample_period=0.1)
    assert np.mean(np.abs(run.collar_speed[1:]) < 1e-3) > 0.01


@pytest.mark.parametrize(("time", "torque"), [(2.0**-3, 2.0**20), (2.0**10, 2.0**-7)])
def test_other_powers_of_two_change_no_bit(time, torque):
    def speeds(s, tau):
        friction = Friction(3.0, v_b=tau)
        start = np.array(SWINGING) / [1.0, 1.0, tau, tau, tau, 1.0, 1.0]
        rig = scaled(time=tau, torque=s, rig=Rig(T_r2=0.05))
        return simulate(rig, friction, start, 0.5 / tau, 4.0 * tau, sample_period=0.05 * tau).state[:, 2:5] * tau

    np.testing.assert_array_equal(speeds(torque, time), speeds(1.0, 1.0))


def test_a_torque_that_vanishes_is_none():
    apart = [
        np.abs(simulate(Rig(T_r2=torque), **STICK_SLIP).state - simulate(Rig(), **STICK_SLIP).state)[:, 2:5].max()
        for torque in (1e-6, 1e-9)
    ]
    assert 1e-8 < apart[0] < 1e-4
    assert apart[1] < 1e-7


def test_energy_that_goes_in_is_stored_or_lost():
    rig, friction = Rig(T_r2=0.1), Friction(20.0)
    run = simulate(rig, friction, speed_reference=2.0, duration=8.0, sample_period=2e-4)
    lost = dissipated_power(rig, friction, run.state)
    work = np.trapezoid(motor_power(rig, run.state) - lost, run.time)
    begin, end = stored_energy(rig, run.state)[[0, -1]]
    assert abs(work - (end - begin)) < 1e-5 * np.trapezoid(np.abs(lost), run.time)
    assert np.all(torque_on_collars(rig, run.collar_speed) * run.collar_speed >= 0.0)


def test_a_disc_2_that_nothing_moves_stays_where_it_is():
    rig = Rig(T_r2=1.0)
    start = frictionless_state(Rig(), 0.0)
    run = simulate(rig, Friction(10.0), start, speed_reference=0.0, duration=5.0)
    np.testing.assert_allclose(run.state, np.broadcast_to(start, run.state.shape), atol=1e-12)


@pytest.mark.slow  # it compiles the stepper for itself
def test_a_disc_2_that_keeps_turning_moves_as_if_it_had_one_mode():
    """Bit for bit: nothing but looks at x_4 is added."""
    rig, friction = Rig(T_r2=0.05), Friction(10.0)
    start = wound_up(rig, friction, 3.0).reshape(7) + 0.5 * np.eye(7)[3]
    tables, ends = build_tables([rig], 0.1), []
    for has_modes in (True, False):
        ladders, work, x = tables.ladders.copy(), workspace(), np.append(start, 0.0)
        ladders["has_modes"] = has_modes
        contact, y = friction.contacts(rig, 3.0)[0], work["y"][0]
        from_equilibrium(x, contact, ladders[0], y)
        slowest = np.inf
        for _ in range(100):
            advance(y, contact, ladders, 0, work[0], False, UNITS)
            slowest = min(slowest, y[3] + 3.0)
        assert slowest > 0.1
        ends.append(y.copy())
    np.testing.assert_array_equal(*ends)


def test_an_orbit_on_which_disc_2_sticks_is_refused():
    with pytest.raises(ValueError, match=r"T_r2 = 0\.1 N m is not constant along it; allowed: T_r2 = 0 N m"):
        stick_slip_orbit(Rig(T_r2=0.1), Friction(20.0), 1.0)


def test_steps_of_other_lengths_lead_to_the_same():
    rig = Rig(T_r2=0.1)
    ends = [simulate(rig, **{**STICK_SLIP, "sample_period": period}).state[-1] for period in (0.75, 0.1, 0.03, 0.002)]
    np.testing.assert_allclose(ends, np.broadcast_to(ends[0], (4, 7)), atol=1e-7)


def test_each_rig_of_a_batch_comes_out_as_alone():
    rig, forces = Rig(T_r2=0.1), np.array([3.0, 10.0, 20.0, 35.0])
    batch = simulate_batch(rig, Friction(forces), speed_reference=2.0, duration=6.0, threads=2)
    for states, force in zip(batch, forces, strict=True):
        alone = simulate(rig, Friction(force), speed_reference=2.0, duration=6.0, sample_period=0.1)
        np.testing.assert_array_equal(states, alone.state)


def begun(rigs, index):
    """An episode of one of some rigs, in deep stick-slip, and its friction."""
    core = EpisodeBatch(1, scenario={"rigs": rigs})
    pins = {"normal_force": 20.0, "speed_target": 1.0, "start": "stick_slip", "rig": index}
    core.reset(np.array([0]), first_uniforms(0, 1), pins)
    return core, Friction(*(float(core.episodes[name][0]) for name in ("normal_force", "mu_s", "mu_k", "v_b")))


def test_rigs_with_and_without_share_a_bank():
    rigs = [Rig(), Rig(T_r2=0.1), Rig(J_1=0.03), Rig(T_r2=0.3)]
    assert len(build_tables(rigs, 0.1).ladders) == len(rigs) + 4
    for index, rig in enumerate(rigs):
        core, friction = begun(rigs, index)
        for _ in range(30):
            state = core.episodes["state"][0, :7].copy()
            core.step(np.full((1, 1), 0.1, dtype=np.float32))
            speed, after = float(core.episodes["speed_reference"][0]), core.episodes["state"][:, :7]
            np.testing.assert_array_equal(simulate_batch(rig, friction, state, speed, 0.1)[:, -1], after)


def test_samples_of_a_control_step_lie_on_the_reference():
    rig = Rig(T_r2=0.1)
    core, friction = begun([rig], 0)
    start = core.episodes["state"][0, :7].copy()
    exact = simulate(rig, friction, start, 1.0, 4.0, sample_period=0.1 / SAMPLES, method="radau")
    assert np.any(np.abs(exact.collar_speed) < 1e-3)
    for one in range(40):
        core.step(np.zeros((1, 1), dtype=np.float32))
        inside = slice(1 + one * SAMPLES, 1 + (one + 1) * SAMPLES)
        torque, bit, record = exact.torque_into_string[inside], exact.bit_speed[inside], core.episodes[0]
        found = [record[name] for name in ("string_torque", "highest_torque", "lowest", "highest", "average")]
        expected = [torque.mean(), torque.max(), bit.min(), bit.max(), bit.mean()]
        np.testing.assert_allclose(found, expected, atol=1e-6)


def test_a_rig_that_cannot_be_computed_is_told_by_its_torque():
    with pytest.raises(ValueError, match=r"Rig: T_r2 = 1e\+12 N m is beyond what can be computed"):
        simulate(Rig(T_r2=1e12))
