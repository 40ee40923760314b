"""The fast stepper against the stored event-split solutions, and its invariants."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate, simulate_batch
from drillrig_env.ladder import LONGEST_PERIOD, ladder
from tests.reference import CASES, arguments, solve, stored

REFERENCE = stored()


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[0]:g}N-{case[1]:g}")
@pytest.mark.parametrize("sample_period", [LONGEST_PERIOD, 0.01])
def test_error_of_every_speed_stays_below_a_millionth(case, sample_period):
    run = simulate(sample_period=sample_period, **arguments(*case))
    every = round(0.1 / sample_period)
    assert np.abs(run.state[::every, 2:5] - REFERENCE[case]).max() <= 1e-6


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
    from drillrig_env.env.core import RigBatch

    core = RigBatch(1, scenario="nominal")
    core.reset(
        np.array([0]), [np.random.default_rng(0)], {"normal_force": 20.0, "speed_target": 2.0, "start": "stick_slip"}
    )
    start = core.rigs["state"][0, :7].copy()
    fine = simulate(
        friction=Friction(20.0), initial_state=start, speed_reference=2.0, duration=5.0, sample_period=0.1 / 16
    )
    for step in range(50):
        core.step(np.zeros((1, 1), dtype=np.float32))
        inside = fine.bit_speed[1 + 16 * step : 17 + 16 * step]
        torque = fine.string_torque[1 + 16 * step : 17 + 16 * step]
        record = core.rigs[0]
        expected = [inside.min(), inside.max(), inside.mean(), torque.max(), torque[-1]]
        found = [record[name] for name in ("lowest", "highest", "average", "highest_torque", "string_torque")]
        np.testing.assert_allclose(found, expected, atol=1e-6)
        assert record["stuck"] == np.mean(inside < 0.01)


@pytest.mark.parametrize("period", [0.0, -0.1, 0.11, float("nan")])
def test_impossible_period_is_refused(period):
    with pytest.raises(ValueError, match=r"period = .* s is not allowed"):
        ladder(Rig(), period)
