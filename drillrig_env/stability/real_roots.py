"""Positive real roots of a polynomial with whole coefficients: every one, and each as closely as wanted.

Sturm's theorem counts the roots between two numbers without finding them, and whole numbers have no rounding. No root
is lost, therefore, however close it lies to another or however many powers of ten lie between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from math import gcd

_BITS = 120
"""Binary digits to which a root is found: twice those of a double, and some more."""


def positive_roots(coefficients: Sequence[int]) -> list[Fraction]:
    """The positive roots, rising; multiple ones once. `coefficients` from the constant (not 0) to the highest power."""
    chain = _sturm_chain(list(coefficients))
    lowest, highest = _exponents(chain[0])
    ends = [_count(chain, 1, lowest), _count(chain, 1, highest)]
    roots: list[Fraction] = []
    parts = [(lowest, highest, *ends)]
    while parts:  # parts (2^low, 2^high], of which the first is the lowest
        low, high, at_low, at_high = parts.pop()
        if at_low == at_high:
            continue
        if high - low == 1:
            roots += _roots_between(chain, low, at_low, at_high)
            continue
        middle = (low + high) // 2
        at_middle = _count(chain, 1, middle)
        parts += [(middle, high, at_middle, at_high), (low, middle, at_low, at_middle)]
    return roots


def _roots_between(chain: list[list[int]], exponent: int, at_low: int, at_high: int) -> list[Fraction]:
    """Roots within (2^exponent, 2^(exponent + 1)], by halving; ends are whole multiples of 2^shift."""
    roots, parts = [], [(1, 2, exponent, at_low, at_high)]
    while parts:
        low, high, shift, at_low, at_high = parts.pop()
        if at_low == at_high:
            continue
        alone = at_low - at_high == 1
        if alone and _sign(chain[0], low, shift) * _sign(chain[0], high, shift) < 0:
            roots.append(_halve(chain[0], low, high, shift, _BITS - (exponent - shift)))
        elif exponent - shift >= _BITS:  # several that no double tells apart, or one that does not cross
            roots.append(_as_fraction(low + high, shift - 1) if alone else _as_fraction(high, shift))
        else:
            middle, at_middle = low + high, _count(chain, low + high, shift - 1)
            parts += [
                (middle, 2 * high, shift - 1, at_middle, at_high),
                (2 * low, middle, shift - 1, at_low, at_middle),
            ]
    return roots


def _halve(polynomial: list[int], low: int, high: int, shift: int, times: int) -> Fraction:
    """The one root between `low` and `high` times 2^shift, where the sign changes, after that many halvings."""
    rising = _sign(polynomial, high, shift)
    for _ in range(times):
        middle, shift = low + high, shift - 1
        low, high = (2 * low, middle) if _sign(polynomial, middle, shift) == rising else (middle, 2 * high)
    return _as_fraction(low + high, shift - 1)


def _sturm_chain(polynomial: list[int]) -> list[list[int]]:
    """The polynomial, its derivative, and the negative remainders of each by the next, but for positive factors."""
    chain = [polynomial, [power * value for power, value in enumerate(polynomial)][1:]]
    while len(chain[-1]) > 1:
        remainder = list(chain[-2])
        divisor = chain[-1]
        leading = abs(divisor[-1])
        sign = 1 if divisor[-1] > 0 else -1
        while len(remainder) >= len(divisor):
            factor, offset = sign * remainder[-1], len(remainder) - len(divisor)
            remainder = [leading * value for value in remainder]
            for power, value in enumerate(divisor):
                remainder[power + offset] -= factor * value
            while remainder and remainder[-1] == 0:
                remainder.pop()
        if not remainder:
            break
        content = gcd(*remainder)
        chain.append([-(value // content) for value in remainder])
    return chain


def _count(chain: list[list[int]], number: int, shift: int) -> int:
    """Changes of sign along the chain at number * 2^shift: their difference between two numbers counts the roots."""
    signs = [sign for polynomial in chain if (sign := _sign(polynomial, number, shift)) != 0]
    return sum(before != after for before, after in pairwise(signs))


def _sign(polynomial: list[int], number: int, shift: int) -> int:
    """Sign of the polynomial at number * 2^shift."""
    value = 0
    if shift >= 0:
        number <<= shift
        for coefficient in reversed(polynomial):
            value = value * number + coefficient
    else:
        for place, coefficient in enumerate(reversed(polynomial)):
            value = value * number + (coefficient << (-shift * place))
    return (value > 0) - (value < 0)


def _exponents(polynomial: list[int]) -> tuple[int, int]:
    """Powers of two below and above every root in size."""
    sizes = [abs(value).bit_length() for value in polynomial]
    highest = max(sizes[:-1]) - sizes[-1] + 2  # Cauchy's bound, 1 + max |a_i / a_n|
    lowest = max(sizes[1:]) - sizes[0] + 2
    return -max(lowest, 1) - 1, max(highest, 1) + 1


def _as_fraction(number: int, shift: int) -> Fraction:
    return Fraction(number << shift) if shift >= 0 else Fraction(number, 1 << -shift)
