"""How well a fit knows its parameters: on residuals whose derivatives are chosen, so that what they tell is known."""

from types import SimpleNamespace

import numpy as np
import pytest

from drillrig_env.calibrate.spread import spread_of
from drillrig_env.calibrate.unknowns import WIDE

NAMES, SAMPLES = 8, 40


def best_of(windows, beforehand, seed=0, ratios_only=True):
    """A fit that is at its minimum, of residuals that are white, and by ratios of the parameters only."""
    random = np.random.default_rng(seed)
    derivatives = random.standard_normal((windows, SAMPLES, len(beforehand)))
    if ratios_only:
        derivatives -= derivatives.mean(axis=2, keepdims=True)
    unknowns = SimpleNamespace(deviations=np.asarray(beforehand))
    residuals = random.standard_normal((windows, SAMPLES))
    problem = SimpleNamespace(unknowns=unknowns)
    return SimpleNamespace(problem=problem, derivatives=[derivatives], residuals=[residuals])


@pytest.mark.parametrize("windows", [6, 60])
def test_a_common_scale_that_nothing_tells_stays_open(windows):
    spread = spread_of(best_of(windows, [WIDE] * NAMES))
    assert not spread.determined.any()
    common = np.full(NAMES, NAMES**-0.5)
    assert 0.95 < common @ spread.covariance @ common / WIDE**2 < 1.6  # what was known beforehand; few make it wider
    ratio = np.eye(NAMES)[0] - np.eye(NAMES)[1]
    assert ratio @ spread.covariance @ ratio < 0.2**2


def test_draws_of_what_is_not_determined_still_fit_the_records():
    spread = spread_of(best_of(60, [WIDE] * 2))
    assert not spread.determined.any()
    draws = spread.draws(200, 0)
    assert draws.std(axis=0).min() > 0.5 * WIDE
    assert np.diff(draws, axis=1).std() < 0.1


@pytest.mark.parametrize("windows", [6, 60])
def test_one_weighed_disc_closes_it(windows):
    spread = spread_of(best_of(windows, [0.02] + [WIDE] * (NAMES - 1)))
    assert spread.determined.tolist() == [False] + [True] * (NAMES - 1)  # the disc is as it was weighed
    assert spread.deviations.max() < 0.25


def test_windows_do_not_claim_more_than_least_squares():
    white = 1.0 / np.sqrt(6 * SAMPLES)
    for seed in range(20):
        spread = spread_of(best_of(6, [WIDE] * 2, seed, ratios_only=False))
        assert spread.deviations.min() > white
    many = [spread_of(best_of(200, [WIDE] * NAMES, seed, ratios_only=False)).deviations for seed in range(5)]
    np.testing.assert_allclose(np.mean(many), 1.0 / np.sqrt(200 * SAMPLES), rtol=0.2)


def test_intervals_hold_where_residuals_hang_together_and_one_window_tells_most():
    random = np.random.default_rng(1)
    windows, names = 24, 3
    derivatives = 0.3 * random.standard_normal((windows, SAMPLES, names)) + random.standard_normal((windows, 1, names))
    derivatives[0, :, 0] *= 3.0
    flat = derivatives.reshape(-1, names)
    held = []
    for _ in range(200):
        errors = 0.5 * random.standard_normal((windows, SAMPLES)) + 0.5 * random.standard_normal((windows, 1))
        logs = -np.linalg.lstsq(flat, errors.ravel(), rcond=None)[0]
        problem = SimpleNamespace(unknowns=SimpleNamespace(deviations=np.full(names, WIDE)))
        residuals = errors + derivatives @ logs
        spread = spread_of(SimpleNamespace(problem=problem, derivatives=[derivatives], residuals=[residuals]))
        held.append(np.abs(logs) < spread.interval())
    assert np.all(np.mean(held, axis=0) > 0.86)  # 0.845 if the first window were taken as it is
    assert np.mean(held) < 0.95
