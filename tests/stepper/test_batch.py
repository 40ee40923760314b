"""Batches of rigs: how many samples, which rig is which, and what is refused."""

import re
from pathlib import Path

import numpy as np
import pytest

import drillrig_env
from drillrig_env import Friction, Rig, simulate, simulate_batch
from drillrig_env.model import frictionless_state, steady_state
from drillrig_env.stepper.batch import advance_batch

FORCES = np.array([5.0, 20.0, 30.0])


@pytest.mark.parametrize(
    ("duration", "period", "samples"),
    [(0.3, 0.1, 4), (0.7, 0.1, 8), (2.3, 0.1, 24), (0.35, 0.1, 4), (0.09, 0.1, 1), (3.3, 1.1, 4), (0.02, 0.005, 5)],
)
def test_samples_are_the_start_and_every_whole_period(duration, period, samples):
    """Durations that are whole periods only up to rounding (0.3 / 0.1 is below 3) count as whole."""
    states = simulate_batch(None, Friction(FORCES), duration=duration, sample_period=period)
    assert states.shape == (3, samples, 7)


def test_defaults_are_half_a_minute_at_two_radians_a_second_every_tenth_of_a_second():
    states = simulate_batch()
    assert states.shape == (1, 301, 7)
    np.testing.assert_array_equal(states[0], simulate(sample_period=0.1).state)


@pytest.mark.parametrize(
    ("period", "parts"),
    [(0.05, 1), (0.1, 1), (0.1 + 0.2, 3), (1 / 3, 4), (0.7, 7), (1.1, 11), (0.1 * (1 + 1e-12), 1), (0.1 + 1e-10, 2)],
)
def test_sample_periods_beyond_the_longest_step_are_cut_into_the_fewest_equal_parts(period, parts):
    """As one rig alone, bit for bit; 0.1 + 0.2 is above 0.3 by rounding alone, and takes three steps of 0.1 s."""
    batch = simulate_batch(None, Friction(FORCES), speed_reference=3.0, duration=3 * period, sample_period=period)
    start = np.broadcast_to(frictionless_state(Rig(), 0.0), (3, 7))
    step = period / parts
    fine = advance_batch(Rig(), Friction(FORCES), start, 3.0, period=step, periods=3 * parts, every=parts)
    np.testing.assert_array_equal(batch[:, 1:], fine)
    alone = simulate(None, Friction(20.0), speed_reference=3.0, duration=3 * period, sample_period=period)
    np.testing.assert_array_equal(batch[1], alone.state)


def test_every_kth_period_is_kept():
    start = steady_state(Rig(), Friction(FORCES), 2.0)
    all_of_them = advance_batch(Rig(), Friction(FORCES), start, 2.5, periods=12)
    np.testing.assert_array_equal(
        advance_batch(Rig(), Friction(FORCES), start, 2.5, periods=12, every=4), all_of_them[:, 3::4]
    )
    assert advance_batch(Rig(), Friction(FORCES), start, 2.5, periods=11, every=4).shape == (3, 2, 7)


def test_each_argument_may_have_one_entry_a_rig_or_one_for_all():
    start = np.stack([steady_state(Rig(), Friction(10.0), speed) for speed in (1.0, 2.0, 3.0)])
    for arguments in (
        {"friction": Friction(FORCES)},
        {"speed_reference": np.array([1.0, 2.0, 3.0])},
        {"initial_state": start},
        {"friction": Friction(FORCES), "speed_reference": np.array([1.0, 2.0, 3.0]), "initial_state": start},
    ):
        assert simulate_batch(**arguments, duration=0.5).shape == (3, 6, 7)
    assert simulate_batch(duration=0.5).shape == (1, 6, 7)
    np.testing.assert_array_equal(simulate_batch(initial_state=start, duration=0.5)[:, 0], start)


def test_steady_rotation_goes_on_under_its_own_friction():
    """Also with a torque on the collars, whose equilibrium the tables are shifted by."""
    rig, friction = Rig(T_r2=0.1), Friction(FORCES)
    start = steady_state(rig, friction, np.array([3.0, 4.0, 5.0]))
    end = simulate_batch(rig, friction, start, np.array([3.0, 4.0, 5.0]), duration=5.0)[:, -1]
    np.testing.assert_allclose(end, start, atol=1e-8)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"duration": 0.0}, "duration = 0.0 s"),
        ({"sample_period": -0.1}, "sample_period = -0.1 s"),
        ({"speed_reference": -1.0}, "speed_reference = -1.0 rad/s"),
        ({"speed_reference": np.ones(2), "friction": Friction(FORCES)}, r"number of rigs = \[2, 3\]"),
        ({"initial_state": np.ones((4, 7)), "speed_reference": np.ones(2)}, r"number of rigs = \[2, 4\]"),
        ({"tolerance": 1e-2}, "tolerance = 0.01 rad/s"),
    ],
)
def test_what_is_not_allowed_is_named(arguments, words):
    with pytest.raises(ValueError, match=words):
        simulate_batch(**arguments)


def test_simulating_at_the_ends_of_what_is_allowed():
    assert simulate_batch(speed_reference=0.0, duration=0.1).shape == (1, 2, 7)


def test_no_kernel_makes_records_of_its_own_memory():
    """To Numba a record is an address in its array: where a kernel makes both, the memory is gone while it is used."""
    own = re.compile(r"np\.(zeros|empty)\([^\n]*dtype=[A-Z_]+\)\[")
    package = Path(drillrig_env.__file__).parent
    found = [path.name for path in package.rglob("*.py") if own.search(path.read_text(encoding="utf-8"))]
    assert found == []
