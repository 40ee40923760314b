"""Many rigs in one batch: each is stepped as by itself, its drive takes it for the nominal one, and resets choose."""

import copy
import pickle
from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

from drillrig_env import Drive, Friction, Rig, make_sb3
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.draws import draw_episodes
from drillrig_env.env.scenario import UNIFORMS, Scenario
from drillrig_env.fleet import Fleet
from drillrig_env.model import jacobian, state_equations
from drillrig_env.simulation import simulate
from drillrig_env.stepper import tables
from drillrig_env.stepper.batch import advance_batch
from drillrig_env.stepper.rungs import longest_rungs

FLEET = Fleet.around(spread={"string": 2.0, "inertias": 1.5, "motor": 1.2, "friction": 1.5}, count=6, seed=2)
SCENARIO = Scenario(rigs=FLEET)
EVERY = np.arange(12)


def begun(scenario=SCENARIO, options=None, **fields):
    core = EpisodeBatch(12, scenario=scenario, threads=1, **fields)
    core.reset(EVERY, np.random.default_rng(5).random((12, UNIFORMS)), options)
    return core


def actions(steps, rigs=12):
    return np.random.default_rng(1).uniform(-1, 1, (steps, rigs, 1)).astype(np.float32)


def test_each_rig_is_stepped_bit_for_bit_as_by_itself():
    core = begun()
    assert len(set(core.episodes["rig"])) > 3
    for action in actions(8):
        before = core.episodes.copy()
        core.step(action)
        for one, after in zip(before, core.episodes, strict=True):
            friction = Friction(after["normal_force"], one["mu_s"], one["mu_k"], one["v_b"])
            rig = FLEET.members().rigs[one["rig"]]
            alone = advance_batch(rig, friction, one["state"][None, :7], after["speed_reference"])
            np.testing.assert_array_equal(after["state"][:7], alone[0, 0])


def test_a_fleet_of_the_nominal_rig_changes_no_bit():
    plain, fleet = begun(scenario="default"), begun(scenario=Scenario(rigs=[Rig()]))
    for action in actions(20):
        plain.step(action)
        fleet.step(action)
    for name in plain.episodes.dtype.names:
        np.testing.assert_array_equal(plain.episodes[name], fleet.episodes[name])
    np.testing.assert_array_equal(plain.observations, fleet.observations)


def test_episodes_begin_in_the_steady_state_or_the_cycle_of_their_own_rig():
    core = begun(options={"start": "steady"})
    for one in core.episodes:
        rig, friction = (
            FLEET.members().rigs[one["rig"]],
            Friction(*(one[k] for k in ("normal_force", "mu_s", "mu_k", "v_b"))),
        )
        torque = friction.torque(rig, one["state"][2])
        assert np.abs(state_equations(one["state"][:7], one["speed_reference"], torque, rig)).max() < 1e-10
    core = begun(options={"start": "stick_slip", "normal_force": 40.0, "speed_target": 1.5})
    core.step(np.zeros((12, 1), np.float32))
    assert (core.episodes["start"] == 0).all()


def test_the_friction_law_is_spread_with_the_rigs():
    members, core = FLEET.members(), begun(scenario=replace(SCENARIO, spread=0.0))
    usual = Friction()
    for one in core.episodes:
        of_mu_k, of_difference, of_v_b = members.friction[one["rig"]]
        assert one["mu_k"] == usual.mu_k * of_mu_k
        assert one["v_b"] == usual.v_b * of_v_b
        assert one["mu_s"] - one["mu_k"] == pytest.approx((usual.mu_s - usual.mu_k) * of_difference)


def test_all_rigs_are_drawn_alike_and_apart_from_everything_else_that_is():
    draws = draw_episodes(
        SCENARIO, np.random.default_rng(0).random((60_000, UNIFORMS)), 60.0, {}, FLEET.members().friction
    )
    counts = np.bincount(draws.rig, minlength=6)
    assert np.abs(counts - 10_000).max() < 5 * np.sqrt(10_000 * 5 / 6)
    for other in (draws.delay, draws.noise, draws.phase, draws.speed_target):
        assert abs(np.corrcoef(draws.rig, other)[0, 1]) < 5 / np.sqrt(60_000)


def test_the_estimated_torque_is_what_nominal_constants_make_of_current_and_speed():
    nominal, core = Rig(), begun(options={"load_steps": []})
    for action in actions(5):
        before = core.episodes.copy()
        core.step(action)
        for was, one in zip(before, core.episodes, strict=True):
            rig = FLEET.members().rigs[one["rig"]]
            friction = Friction(*(one[name] for name in ("normal_force", "mu_s", "mu_k", "v_b")))
            fine = simulate(rig, friction, was["state"][:7], one["speed_reference"], 0.1, 1e-4).state
            current, top = (np.trapezoid(fine[:, k], dx=1e-3) for k in (5, 4))
            motor = nominal.eta * nominal.K_T * current - nominal.eta**2 * nominal.C_m * top
            inertia = nominal.J_3 * (fine[-1, 4] - fine[0, 4]) / 0.1
            expected = motor - nominal.eta * nominal.T_f - inertia
            assert one["string_torque"] == pytest.approx(expected, abs=0.012)


@pytest.mark.parametrize(("knows", "seen"), [("nameplate", Rig().K_E * Rig().eta), ("motor", None)])
def test_the_back_emf_that_the_drive_makes_up_for_is_the_nameplates_or_the_motors(knows, seen):
    drive = Drive(0.04, 0.007, 0.9, knows)
    core = begun(drive=drive)
    before = core.episodes.copy()
    core.step(actions(1)[0])
    for was, one in zip(before, core.episodes, strict=True):
        rig = FLEET.members().rigs[one["rig"]]
        constant = 0.9 * (seen or rig.K_E * rig.eta)
        voltage = (
            0.04 * (one["speed_reference"] - one["state"][4]) + 0.007 * one["state"][6] + constant * one["state"][4]
        )
        assert one["voltage"] == pytest.approx(voltage, rel=1e-12)
        rates = jacobian(replace(rig, k_p=0.04, k_i=0.007))
        rates[5, 4] += constant / rig.L
        np.testing.assert_allclose(jacobian(rig, drive=drive.on(Rig())), rates, rtol=1e-12)
        assert np.isfinite(was["state"]).all()


def test_episodes_are_stepped_rig_by_rig_and_in_any_other_order_alike():
    core, other = begun(), begun()
    assert (np.diff(core.episodes["rig"][core._order]) >= 0).all()
    other._order[:] = np.random.default_rng(2).permutation(len(other))
    for action in actions(6):
        core.step(action)
        other.step(action)
        np.testing.assert_array_equal(core.observations, other.observations)
    np.testing.assert_array_equal(core.episodes, other.episodes)
    core.reset(np.array([1, 4]), np.random.default_rng(5).random((2, UNIFORMS)), {"rig": [5, 0]})
    assert (np.diff(core.episodes["rig"][core._order]) >= 0).all()
    core.set_state(other.get_state())
    assert (np.diff(core.episodes["rig"][core._order]) >= 0).all()


def test_a_reset_chooses_rigs_by_index_or_by_themselves():
    own = Rig(J_1=0.05)
    core = begun(options={"rig": [3, own, 0, own, Rig(k_2=0.5)] + [5] * 7})
    assert core.info()["rig"].tolist() == [3, 6, 0, 6, 7, *[5] * 7]
    assert core.bank.rigs[6:] == (own, Rig(k_2=0.5))
    core.reset(np.array([1, 4]), np.random.default_rng(5).random((2, UNIFORMS)), {"rig": Rig(k_2=0.6)})
    assert [core.bank.rigs[k].k_2 for k in core.episodes["rig"][[1, 3, 4]]] == [0.6, own.k_2, 0.6]
    assert len(core.bank.rigs) == 8  # the rig that no episode has any more is gone


@pytest.mark.parametrize("drive", [None, Drive(k_p=1.0, k_i=0.5)])
def test_a_rig_beside_a_fleet_costs_no_tables_but_its_own(monkeypatch, drive):
    core, made = begun(drive=drive), []
    monkeypatch.setattr(tables, "longest_rungs", lambda *given: made.append(given) or longest_rungs(*given))
    core.reset(EVERY[:1], np.full((1, UNIFORMS), 0.5), {"rig": Rig(J_1=0.0513)})
    assert len(made) == (1 if drive is None else 2)
    assert core.info()["rig"][0] == len(FLEET.members())


def test_rigs_that_episodes_have_outlive_a_change_of_the_fleet():
    core, other = begun(), begun()
    core.change(scenario=Scenario(rigs=[Rig(J_1=0.04)]))
    for action in actions(6):
        core.step(action)
        other.step(action)
    np.testing.assert_array_equal(core.episodes["state"], other.episodes["state"])
    core.reset(EVERY, np.random.default_rng(5).random((12, UNIFORMS)))
    assert (core.episodes["rig"] == 0).all()
    assert core.bank.rigs[0].J_1 == 0.04


@pytest.mark.parametrize("form", ["single", "vector", "sb3"])
def test_copies_and_states_go_on_with_the_same_rigs_in_every_form(form):
    rate = np.full((1,), 0.5, np.float32)
    if form == "single":
        env = gym.make("DrillRig-v0", scenario=SCENARIO).unwrapped
        env.reset(seed=1, options={"rig": Rig(J_1=0.05)})
        go = lambda env: env.step(rate)[0]  # noqa: E731
    elif form == "vector":
        env = gym.make_vec("DrillRig-v0", num_envs=3, scenario=SCENARIO)
        env.reset(seed=1, options={"rig": [Rig(J_1=0.05), 2, 4]})
        go = lambda env: env.step(np.stack([rate] * 3))[0]  # noqa: E731
    else:
        env = make_sb3(3, scenario=SCENARIO, seed=1)
        env.set_options({"rig": Rig(J_1=0.05)})
        env.reset()
        go = lambda env: env.step(np.stack([rate] * 3))[0]  # noqa: E731
    go(env)
    state = env.get_state()
    others = copy.deepcopy(env), pickle.loads(pickle.dumps(env))
    expected = [go(env) for _ in range(3)]
    for other in others:
        np.testing.assert_array_equal([go(other) for _ in range(3)], expected)
    env.reset(seed=9, options={"rig": 0}) if form != "sb3" else env.reset()
    go(env)
    env.set_state(state)
    np.testing.assert_array_equal([go(env) for _ in range(3)], expected)


def test_the_single_rig_follows_a_changed_fleet():
    env = gym.make("DrillRig-v0", scenario=Scenario(rigs=[Rig(J_1=0.05)])).unwrapped
    env.reset(seed=0)
    env.change(scenario=Scenario(rigs=[Rig(J_1=0.05)] * 40))
    _, info = env.reset(seed=0)
    assert info["rig"].dtype == np.int64
    assert all(np.isfinite(env.step(np.ones(1, np.float32))[0]).all() for _ in range(30))


@pytest.mark.parametrize(
    ("rig", "words"),
    [
        (6, "rig = 6 is not allowed; allowed: whole, >= 0 and <= 5, or a Rig"),
        (-1, "rig = -1"),
        (1.5, "rig = 1.5"),
        ([0, 1], "number of rigs = 2 is not allowed; allowed: one, or 12"),
        ({"J_9": 1.0}, "unknown key J_9"),
        ("no_such_rig.toml", "no_such_rig.toml"),
        (None, "rig = None"),
    ],
)
def test_what_no_reset_can_have_is_refused(rig, words):
    with pytest.raises((ValueError, FileNotFoundError), match=words):
        begun(options={"rig": rig})
