"""The random generators of many rigs: each its own, as Gymnasium seeds it, in 32 bytes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.utils import seeding

from drillrig_env.allowed import Allowed
from drillrig_env.arrays import FloatArray
from drillrig_env.env.scenario import UNIFORMS
from drillrig_env.parameters import checked

_HALF = 1 << 64
_SEEDS = Allowed(low=0, whole=True)


class EpisodeGenerators:
    """One generator a rig, and all that an episode draws from it.

    A NumPy generator takes above a kilobyte, its PCG64 state 32 bytes. So the states lie in one array,
    `states` of shape (rigs, 4), and one generator goes from rig to rig. It draws for rig i with the seed s just what
    `gymnasium.utils.seeding.np_random(s)` does. `seeds` are those that were last given.
    """

    def __init__(self, rigs: int) -> None:
        self.states = np.zeros((rigs, 4), dtype=np.uint64)
        self.seeds: list[int | None] = [None] * rigs
        self._bits = np.random.PCG64(0)
        self._generator = np.random.Generator(self._bits)

    def __getstate__(self) -> tuple[np.ndarray, list[int | None]]:
        return self.states, self.seeds

    def __setstate__(self, state: tuple[np.ndarray, list[int | None]]) -> None:
        states, seeds = state
        self.__init__(len(states))  # type: ignore[misc]
        self.states[:], self.seeds = states, seeds

    @property
    def seeded(self) -> bool:
        """Whether the rigs have been given seeds; a PCG64 state is never all zeros."""
        return bool(self.states.any())

    def seed(self, rig: int, seed: int | None) -> int:
        """Give a rig a seed, or fresh entropy for None; returns the seed that was used."""
        generator, used = seeding.np_random(check_seed(seed))
        self._keep(rig, generator.bit_generator)
        self.seeds[rig] = used
        return used

    def seed_all(self, seed: Any) -> None:
        """Seed rig i with `seed` + i, or each of a list with its own; None seeds rigs that have no seed yet.

        Raises `ValueError` for another number of seeds, and for what is no whole number >= 0.
        """
        begun, rigs = self.seeded, len(self.states)
        if seed is None and begun:
            return
        if isinstance(seed, Sequence | np.ndarray) and not isinstance(seed, str) and np.ndim(seed) == 1:
            seeds = [check_seed(one) for one in seed]
        else:
            first = check_seed(seed)
            seeds = [None if first is None else first + i for i in range(rigs)]
        if len(seeds) != rigs:
            raise ValueError(f"{len(seeds)} seeds are not allowed; allowed: one number, or {rigs}")
        for rig, one in enumerate(seeds):
            if one is not None or not begun:
                self.seed(rig, one)

    def uniforms(self, rigs: npt.NDArray[np.intp]) -> FloatArray:
        """The next uniform numbers on [0, 1) for an episode of each of `rigs`; shape (n, UNIFORMS)."""
        drawn = np.empty((len(rigs), UNIFORMS))
        for row, rig in zip(drawn, rigs, strict=True):
            high, low, high_step, low_step = self.states[rig].tolist()
            state: Any = {"state": high * _HALF + low, "inc": high_step * _HALF + low_step}
            self._bits.state = {"bit_generator": "PCG64", "state": state, "has_uint32": 0, "uinteger": 0}
            self._generator.random(out=row)
            self._keep(rig, self._bits)
        return drawn

    def _keep(self, rig: int, bits: np.random.BitGenerator) -> None:
        state = bits.state["state"]
        self.states[rig] = (*divmod(state["state"], _HALF), *divmod(state["inc"], _HALF))


def check_seed(seed: Any) -> int | None:
    """A seed as Gymnasium takes it, or None. `ValueError` for what is no whole number >= 0.

    It may have any size: the seed of an environment that was given none, which can be given to another, has 128 bits.
    """
    return None if seed is None else int(checked("DrillRig", "seed", seed, "", _SEEDS))


def first_uniforms(first_seed: int, rigs: int) -> FloatArray:
    """What the first episodes of rigs with the seeds `first_seed`, `first_seed` + 1, ... draw; (rigs, UNIFORMS)."""
    return np.stack([seeding.np_random(first_seed + i)[0].random(UNIFORMS) for i in range(rigs)])
