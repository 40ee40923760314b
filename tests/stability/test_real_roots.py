"""Positive real roots of polynomials whose roots are known, however close or far apart."""

from fractions import Fraction
from math import lcm

import numpy as np
import pytest

from drillrig_env.stability.real_roots import positive_roots


def polynomial(*roots, factor=1):
    """Whole coefficients, from the constant on, of factor * prod(x - root)."""
    coefficients = [Fraction(factor)]
    for root in roots:
        shifted = [Fraction(0), *coefficients]
        scaled = [-Fraction(root) * value for value in coefficients] + [Fraction(0)]
        coefficients = [a + b for a, b in zip(shifted, scaled, strict=True)]
    whole = lcm(*(value.denominator for value in coefficients))
    return [int(value * whole) for value in coefficients]


@pytest.mark.parametrize(
    "roots",
    [
        [3],
        [Fraction(1, 3), 7, 11],
        [1, 2, 4, 8, 16, 1024],  # powers of two, the ends of the first parts
        [Fraction(3, 7), 1, 1],  # a root that only touches
        [5, 5, 5],
        [10**40, Fraction(1, 10**40), 3],
        [Fraction(10**20 + 1, 10**20), 1],
        [Fraction(1, 7), Fraction(2, 7), Fraction(3, 7), Fraction(4, 7), Fraction(5, 7), Fraction(6, 7)],
    ],
)
@pytest.mark.parametrize("others", [[], [-2, -3], [-1, Fraction(-1, 9)]])
def test_every_positive_root_is_found_once_and_no_other(roots, others):
    found = positive_roots(polynomial(*roots, *others, factor=-3))
    wanted = sorted({Fraction(root) for root in roots})
    assert len(found) == len(wanted)
    for got, root in zip(found, wanted, strict=True):
        assert abs(got - root) <= root * Fraction(1, 2**100)


def test_roots_off_the_real_line_are_none():
    assert positive_roots([5, -2, 1]) == []  # 1 +- 2i
    assert [float(root) for root in positive_roots([-15, 11, -5, 1])] == [3.0]  # and 3


def test_random_polynomials_have_the_roots_that_numpy_finds():
    rng = np.random.default_rng(4)
    for _ in range(50):
        coefficients = rng.integers(-9, 10, 7).tolist()
        if coefficients[0] == 0 or coefficients[-1] == 0:
            continue
        values = np.roots(coefficients[::-1])
        expected = np.sort(values.real[(np.abs(values.imag) < 1e-7) & (values.real > 0)])
        np.testing.assert_allclose([float(root) for root in positive_roots(coefficients)], expected, rtol=1e-6)
