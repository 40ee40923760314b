"""Random numbers in compiled code: SplitMix64 (Steele, Lea & Flood, 2014), whose state is one number.

Each function returns the next state with what it has drawn. Normal numbers come by Box and Muller, or at a fifth of
their cost by the ziggurat of Marsaglia & Tsang (2000): 256 layers of one area under the density, of which a point is
nearly always below it.
"""

from __future__ import annotations

from math import cos, erfc, exp, log, pi, sqrt
from typing import Any

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.jit.compiled import compiled, inlined

_LAYERS, _TAIL = 256, 3.6541528853610088
"""Layers of the ziggurat, and where the last one's tail begins; from the paper."""


def _edges() -> FloatArray:
    """Right edges of the layers, from the lowest one, which has the tail, to the top at 0."""
    area = _TAIL * exp(-0.5 * _TAIL**2) + sqrt(pi / 2.0) * erfc(_TAIL / sqrt(2.0))
    edges = [area / exp(-0.5 * _TAIL**2), _TAIL]
    while len(edges) < _LAYERS:
        edges.append(sqrt(-2.0 * log(exp(-0.5 * edges[-1] ** 2) + area / edges[-1])))
    return np.array([*edges, 0.0])


_EDGES = _edges()
_HEIGHTS = np.exp(-0.5 * _EDGES**2)


@inlined
def gaussian(state: Any) -> tuple[Any, float]:
    """A standard normal number, by Box and Muller."""
    state, first = uniform(state)
    radius = sqrt(-2.0 * log(1.0 - first))
    state, second = uniform(state)
    return state, radius * cos(2.0 * pi * second)


@inlined
def fast_gaussian(state: Any) -> tuple[Any, float]:
    """A standard normal number, by the ziggurat; other ones than those of `gaussian`."""
    state, z = bits(state)
    layer = z & np.uint64(_LAYERS - 1)
    x = (float(z >> np.uint64(11)) * 2.0**-52 - 1.0) * _EDGES[layer]
    if abs(x) < _EDGES[layer + np.uint64(1)]:
        return state, x
    return _beyond(state, layer, x)


@compiled
def _beyond(state: Any, layer: Any, x: float) -> tuple[Any, float]:
    """What comes of a point in the part of a layer that the density cuts, or in the tail."""
    while True:
        if layer == 0:
            far, high = 0.0, 0.0
            while 2.0 * high <= far * far:
                state, first = uniform(state)
                state, second = uniform(state)
                far, high = -log(1.0 - first) / _TAIL, -log(1.0 - second)
            return state, (_TAIL + far if x > 0.0 else -_TAIL - far)
        state, height = uniform(state)
        low, top = _HEIGHTS[layer], _HEIGHTS[layer + np.uint64(1)]
        if low + height * (top - low) < exp(-0.5 * x * x):
            return state, x
        state, z = bits(state)
        layer = z & np.uint64(_LAYERS - 1)
        x = (float(z >> np.uint64(11)) * 2.0**-52 - 1.0) * _EDGES[layer]
        if abs(x) < _EDGES[layer + np.uint64(1)]:
            return state, x


@inlined
def uniform(state: Any) -> tuple[Any, float]:
    """A uniform number on [0, 1)."""
    state, z = bits(state)
    return state, float(z >> np.uint64(11)) * 2.0**-53


@inlined
def bits(state: Any) -> tuple[Any, Any]:
    """64 random bits."""
    state += np.uint64(0x9E3779B97F4A7C15)
    z = state
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return state, z ^ (z >> np.uint64(31))
