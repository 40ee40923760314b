"""The fast stepper against the stored event-split solutions, and its invariants."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate, simulate_batch
from drillrig_env.model import jacobian
from drillrig_env.stepper.batch import advance_batch
from drillrig_env.stepper.exponentials import RADAU_NODES
from drillrig_env.stepper.ladder import STATE
from drillrig_env.stepper.landing import land
from drillrig_env.stepper.propagator import _lose
from drillrig_env.stepper.settling import split
from drillrig_env.stepper.tables import LONGEST_PERIOD, step_tables
from drillrig_env.stepper.workspace import workspace
from tests.reference import CASES, arguments, solve, stored

REFERENCE = stored()


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[0]:g}N-{case[1]:g}")
@pytest.mark.parametrize(("sample_period", "allowed"), [(LONGEST_PERIOD, 1e-6), (0.01, 1e-8)])
def test_error_of_every_speed_stays_below_a_millionth(case, sample_period, allowed):
    run = simulate(sample_period=sample_period, **arguments(*case))
    every = round(0.1 / sample_period)
    assert np.abs(run.state[::every, 2:5] - REFERENCE[case]).max() <= allowed


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
def test_error_stays_below_the_tolerance_that_is_asked_for(tolerance):
    errors = [
        np.abs(simulate(sample_period=LONGEST_PERIOD, tolerance=tolerance, **arguments(*case)).state[:, 2:5] - speeds)
        for case, speeds in REFERENCE.items()
    ]
    assert max(error.max() for error in errors) <= tolerance


def test_tolerance_out_of_range_is_refused():
    with pytest.raises(ValueError, match=r"tolerance = 1e-09 rad/s is not allowed; allowed: 1e-07 to 0\.001"):
        simulate(tolerance=1e-9)


def test_published_values_of_a_stick_slip_run():
    start = (0.0, 0.0, 2.0, 2.0, 2.0, 0.5, 0.0)
    run = simulate(friction=Friction(20.0), initial_state=start, speed_reference=2.0, duration=20.0)
    expected = {2: 4.188215400792, 5: 3.608066514359, 10: 3.403691148538, 20: 2.412278185992}
    for time, speed in expected.items():
        assert run.bit_speed[round(time / 0.01)] == pytest.approx(speed, abs=1e-8)


@pytest.mark.slow
def test_stored_reference_comes_out_again():
    for case in CASES[::6]:
        np.testing.assert_allclose(solve(case), REFERENCE[case], atol=1e-8)


def random_batch(rigs=200):
    rng = np.random.default_rng(7)
    friction = Friction(
        rng.uniform(2, 40, rigs), rng.uniform(0.4, 0.6, rigs), rng.uniform(0.2, 0.4, rigs), rng.uniform(0.7, 1.3, rigs)
    )
    states = rng.normal(size=(rigs, 7)) * [0.3, 1.0, 3.0, 3.0, 3.0, 1.0, 1.0]
    return friction, states, rng.uniform(0.0, 10.0, rigs)


def one(friction, rig):
    return Friction(*friction.as_array()[rig].tolist())


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_batch_is_bit_for_bit_its_rigs_one_at_a_time(threads):
    friction, states, references = random_batch()
    batch = simulate_batch(None, friction, states, references, duration=5.0, threads=threads)
    assert batch.shape == (200, 51, 7)
    for rig in range(0, 200, 7):
        alone = simulate(None, one(friction, rig), states[rig], float(references[rig]), 5.0, sample_period=0.1)
        np.testing.assert_array_equal(batch[rig], alone.state)


@pytest.mark.parametrize(
    ("heaviest", "highest_reference", "omega_s"),
    [(2, 10, 1e-3), (40, 0.5, 1e-3), (40, 0, 1e-3), (40, 5, 0.1), (40, 5, 1e-5), (400, 5, 1e-3)],
)
def test_long_steps_agree_with_short_ones(heaviest, highest_reference, omega_s):
    """Light loads have no fast settling to split off, wide stick zones much sliding, narrow ones jumps."""
    rng = np.random.default_rng(5)
    friction, states, references = Friction(rng.uniform(0, heaviest, 40)), random_batch(40)[1], rng.uniform(size=40)
    runs = [
        advance_batch(
            Rig(omega_s=omega_s), friction, states, highest_reference * references, period=period, periods=periods
        )[:, -1, 2:5]
        for period, periods in ((0.1, 40), (0.01, 400))
    ]
    np.testing.assert_allclose(*runs, atol=1e-5)


def test_fast_settling_is_a_mode_of_the_stick_zone():
    rig, sigma = Rig(), 20.0 * Rig().r_1 * 0.5 / 1e-3
    contact = Friction(20.0).contacts(rig, 0.0)[0]
    ladder, work = step_tables(rig, 0.1).ladders[0], workspace()[0]
    state = np.array([-0.4, -1.3, 1e-3, 0.1, 0.2, 0.3, 0.4, 0.0])
    y = state.copy()
    amplitude, rate = split(y, contact, ladder, 4, work)
    M = jacobian(rig, sigma)
    values, vectors = np.linalg.eig(M)
    fastest = np.argmin(values.real)
    assert rate == pytest.approx(values[fastest].real * 0.1 / 16, rel=1e-12)
    np.testing.assert_allclose(work["fast"][:7], (vectors[:, fastest] / vectors[2, fastest]).real, atol=1e-9)
    np.testing.assert_allclose(y + amplitude * work["fast"], state, atol=1e-15)
    assert (np.linalg.inv(vectors) @ y[:7])[fastest] == pytest.approx(0.0, abs=1e-12)


def test_light_bit_has_no_fast_settling():
    y = np.full(STATE, 0.1)
    contact = Friction(0.005).contacts(Rig(), 0.0)[0]
    assert split(y, contact, step_tables(Rig(), 0.1).ladders[0], 4, workspace()[0]) == (0.0, 0.0)
    np.testing.assert_array_equal(y, 0.1)


def test_landing_inside_a_step_is_exact():
    """The state half-way through a step is that of a step of half the length with the same torque."""
    ladder = step_tables(Rig(), 0.1).ladders[0]
    work, start = workspace()[0], np.array([-0.4, -1.3, 2.0, 1.0, 3.0, 0.3, 0.4, 0.0])
    work["torque"] = RADAU_NODES**3 - 0.2 * RADAU_NODES + 0.3
    y = start.copy()
    assert land(y, ladder, 4, work, 0.5)
    torque = (0.5 * RADAU_NODES) ** 3 - 0.1 * RADAU_NODES + 0.3
    expected = start[:7] @ ladder["rungs"][5]["state_from_state"] + torque @ ladder["rungs"][5]["state_from_torque"]
    np.testing.assert_allclose(y, expected, atol=1e-12)


def test_order_of_rigs_does_not_matter():
    friction, states, references = random_batch()
    order = np.random.default_rng(0).permutation(200)
    batch = simulate_batch(None, friction, states, references, duration=5.0)
    shuffled = simulate_batch(
        None, Friction(*friction.as_array()[order].T), states[order], references[order], duration=5.0
    )
    np.testing.assert_array_equal(batch[order], shuffled)


def test_mirrored_rig_moves_in_the_mirror():
    rig = Rig(T_f=0.0)  # the model's T_f does not turn round with the motor
    friction, states, _ = random_batch()
    there = simulate_batch(rig, friction, states, 0.0, duration=3.0)
    back = simulate_batch(rig, friction, -states, 0.0, duration=3.0)
    np.testing.assert_allclose(there, -back, atol=1e-12)


def test_samples_inside_a_period_lie_on_the_solution():
    from drillrig_env.env.core import EpisodeBatch
    from drillrig_env.env.generators import first_uniforms

    core = EpisodeBatch(1, scenario="nominal")
    core.reset(np.array([0]), first_uniforms(0, 1), {"normal_force": 20.0, "speed_target": 2.0, "start": "stick_slip"})
    start = core.episodes["state"][0, :7].copy()
    fine = simulate(
        friction=Friction(20.0), initial_state=start, speed_reference=2.0, duration=5.0, sample_period=0.1 / 16
    )
    for step in range(50):
        core.step(np.zeros((1, 1), dtype=np.float32))
        inside = fine.bit_speed[1 + 16 * step : 17 + 16 * step]
        torque = fine.torque_into_string[1 + 16 * step : 17 + 16 * step]
        record = core.episodes[0]
        expected = [inside.min(), inside.max(), inside.mean(), torque.max(), torque[-1]]
        found = [record[name] for name in ("lowest", "highest", "average", "highest_torque", "torque_into_string")]
        np.testing.assert_allclose(found, expected, atol=1e-6)
        assert record["stuck"] == np.mean(inside < 0.01)


@pytest.mark.parametrize("period", [0.0, -0.1, float("inf"), float("nan")])
def test_impossible_period_is_refused(period):
    with pytest.raises(ValueError, match=r"period = .* s is not allowed"):
        step_tables(Rig(), period)


@pytest.mark.parametrize(("largest", "marked"), [(3.0, np.nan), (1e308, np.inf), (np.nan, np.inf)])
def test_a_step_that_is_not_solved_is_marked_and_an_overflow_tells_itself_apart(largest, marked):
    y, work = np.array([0.1, 0.2, 1.0, largest, 1.0, 0.5, 0.0, 0.0]), workspace().view(np.recarray)[0]
    _lose.py_func(y, work)
    np.testing.assert_array_equal(y[:7], marked)
