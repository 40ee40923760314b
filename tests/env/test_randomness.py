"""Random numbers of the kernels: uniform, and normal in two ways."""

import numba
import numpy as np
import pytest
from scipy import stats

from drillrig_env.env.randomness import fast_gaussian, gaussian, uniform


def drawn(one, count, seed):
    @numba.njit
    def draw(state):
        found = np.empty(count)
        for i in range(count):
            state, found[i] = one(state)
        return found

    return draw(np.uint64(seed))


def test_uniform_numbers_are_uniform():
    found = drawn(uniform, 200_000, 1)
    assert 0.0 <= found.min() < found.max() < 1.0
    assert stats.kstest(found, "uniform").pvalue > 1e-3


@pytest.mark.parametrize("one", [gaussian, fast_gaussian])
def test_normal_numbers_are_normal_and_independent(one):
    found = drawn(one, 1_000_000, 7)
    assert stats.kstest(found, "norm").pvalue > 1e-3
    assert stats.kstest(found**2, "chi2", (1,)).pvalue > 1e-3
    assert abs(np.corrcoef(found[:-1], found[1:])[0, 1]) < 5e-3
    for threshold in (2.5, 3.6541528853610088, 4.2):  # the second is where the ziggurat's tail begins
        for side in (found, -found):
            expected = len(found) * stats.norm.sf(threshold)
            assert abs(np.count_nonzero(side > threshold) - expected) < 5.0 * np.sqrt(expected)
