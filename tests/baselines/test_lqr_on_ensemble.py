"""An ensemble of simulated rigs finds the force and the state that it is not told, and feedback on it does as well."""

import numpy as np
import pytest

from baselines.ensemble import CHANNELS, FORCE, MEMBERS, SIZE, Ensemble
from baselines.lqr_on_ensemble import LQROnEnsemble
from baselines.told import LQROfRig
from drillrig_env import Friction, Rig
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.fleet import Fleet
from drillrig_env.model import STATE_NAMES
from drillrig_env.policy import check_policy
from tests.rigs import FIELD

RIGS = (Rig(k_2=0.5, J_1=0.02), Rig(), Rig(k_1=0.8, K_T=0.12, K_E=0.07, J_3=0.03))
FLEET = Fleet(rigs=RIGS)
FORCES = np.array([12.0, 20.0, 8.0])


def sticking(noise=1.0, delay=1, load_steps=()):
    """Three rigs of the fleet in stick-slip, each with another force, seen from the surface."""
    scenario = {"rigs": FLEET, "spread": 0.0}
    core = EpisodeBatch(3, scenario=scenario, sensors="surface", threads=1, noise=noise, delay=delay)
    pins = {"rig": [0, 1, 2], "start": "stick_slip", "speed_target": 1.8, "normal_force": FORCES}
    core.reset(np.arange(3), first_uniforms(0, 3), {**pins, "load_steps": list(load_steps)})
    return core


def play(core, steps):
    """Let the policy play; yields its mean members of the measured moment, and its actions, before each step."""
    policy, state = LQROnEnsemble("surface", fleet=FLEET, threads=1), None
    for _ in range(steps):
        policy.tell(core.info())
        actions, state = policy.predict(core.observations, state)
        yield state[0][:, -MEMBERS * SIZE :].reshape(3, MEMBERS, SIZE).mean(axis=1), actions
        core.step(actions)


@pytest.mark.parametrize("context", [{"fleet": FLEET}, {"rig": FIELD}])
def test_keeps_the_contract(context):
    check_policy(LQROnEnsemble, **context)


@pytest.mark.parametrize("delay", [0, 3])
def test_finds_the_force_and_the_state_of_the_moment_that_was_measured(delay):
    """Of that moment and of no other: two steps off, states of a rig that shakes differ by far more."""
    core, states, found = sticking(delay=delay), [], None
    for mean, _ in play(core, 80):
        states.append(core.episodes["state"][:, :7].copy())
        found = mean
    np.testing.assert_allclose(np.exp(found[:, FORCE]), FORCES, rtol=0.03)
    speed, twist = CHANNELS.index("bit_speed"), CHANNELS.index("twist_23")
    assert np.abs(found[:, speed] - states[-1 - delay][:, speed]).max() < 0.15
    assert np.abs(found[:, twist] - states[-1 - delay][:, twist]).max() < 0.05


def test_a_load_step_that_nobody_tells_is_found():
    core = sticking(load_steps=[(10.0, 16.0)])
    for mean, _ in play(core, 200):
        found = np.exp(mean[:, FORCE])
    np.testing.assert_allclose(found, 16.0, rtol=0.05)


def test_without_noise_it_acts_as_the_law_that_is_told_the_state():
    """Told it as it is, of now: an estimate that were not brought up to the present would act otherwise."""
    core, exact, state, differ = sticking(noise=0.0, delay=2), LQROfRig(fleet=FLEET, effort=30.0), None, []
    ours = LQROnEnsemble("surface", fleet=FLEET, calm_effort=30.0, threads=1)
    memory = None
    for _ in range(160):
        info = core.info()
        exact.tell(info)
        ours.tell(info)
        wanted, state = exact.predict(_shown(exact, core), state)
        actions, memory = ours.predict(core.observations, memory)
        differ.append(np.abs(actions - wanted).max())
        core.step(actions)
    assert np.median(differ[80:]) < 0.02
    assert np.mean(np.array(differ[80:]) < 0.1) > 0.9


def test_a_measurement_draws_as_the_kalman_filter_of_its_members():
    """Mean and covariance of the members are those of the textbook's update, for two channels at once."""
    random = np.random.default_rng(0)
    members = random.standard_normal((1, MEMBERS, SIZE)) @ random.standard_normal((SIZE, SIZE))
    members[:, :, FORCE - 1] += 50.0  # a deviation is not negative
    noise, measured = {"top_speed": 0.5, "current": 2.0}, {}
    rows = [CHANNELS.index(name) for name in noise]
    for name, k in zip(noise, rows, strict=True):
        measured[name] = members[:, :, k].mean(axis=1) + 0.1
    filters = Ensemble((Rig(),), Rig(), Friction(1.0), 2.0, 0.1, noise, 1)
    before = np.cov(members[0].T) * 1.002**2
    gain = before[:, rows] @ np.linalg.inv(before[np.ix_(rows, rows)] + np.diag(np.square(list(noise.values()))))
    drawn = filters.drawn_to(measured, members)[0]
    free = [k for k in range(SIZE) if k != FORCE]  # the force is kept within bounds
    np.testing.assert_allclose(drawn.mean(axis=0)[free], (members[0].mean(axis=0) + gain @ [0.1, 0.1])[free])
    after = before - gain @ before[rows]
    np.testing.assert_allclose(np.cov(drawn.T)[np.ix_(free, free)], after[np.ix_(free, free)], rtol=1e-8, atol=1e-9)


def _shown(policy, core):
    """Observations of the exact state, shape (n, channels); what feedback of the state does not look at is 0."""
    columns, target = np.zeros((len(core.episodes), len(policy.sensors.names))), core.episodes["speed_target"]
    for k, one in enumerate(policy.sensors.channels):
        if one.name in STATE_NAMES:
            value = core.episodes["state"][:, STATE_NAMES.index(one.name)]
        elif one.name in ("speed_reference", "speed_target"):
            value = core.episodes[one.name]
        else:
            continue
        columns[:, k] = (value - (target if one.offset == "target" else one.offset)) / one.scale
    return columns.astype(np.float32)
