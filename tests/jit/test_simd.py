"""Vectors of the processor give what NumPy gives, bit for bit."""

import numba
import numpy as np
import pytest

from drillrig_env.jit.simd import row, store

RNG = np.random.default_rng(0)


@numba.njit
def combine(table, weights, out):
    store(out, 0, 0.1 + weights[0] * row(table, 0, 4) + weights[1] * row(table, 1, 4))
    store(out, 4, weights[0] * (row(table, 0, 4) + row(weights, 2, 4)))


def test_rows_add_and_multiply_like_numpy():
    table, weights, out = RNG.normal(size=(2, 6)), RNG.normal(size=6), np.zeros(9)
    combine(table, weights, out)
    np.testing.assert_array_equal(out[:4], 0.1 + weights[0] * table[0, :4] + weights[1] * table[1, :4])
    np.testing.assert_array_equal(out[4:8], weights[0] * (table[0, :4] + weights[2:]))
    assert out[8] == 0.0


def test_length_of_a_row_must_be_a_constant():
    @numba.njit
    def first(table, count, out):
        store(out, 0, row(table, 0, count))

    with pytest.raises(numba.TypingError, match="count of a row must be a constant"):
        first(np.ones((2, 4)), 4, np.zeros(4))
