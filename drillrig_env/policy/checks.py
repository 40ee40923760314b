"""Whether a policy keeps the contract: tests that any controller can run on itself."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import Actions, Observations
from drillrig_env.policy.contract import Memory, Policy, channels_of, drive_of, is_exact, privileged_of
from drillrig_env.policy.finding import find_policy
from drillrig_env.scales import Scales

_RIGS, _STEPS, _CHANNELS = 6, 8, 12
_ROUNDING = 1e-5
"""What an action may differ by with a rig's company: a network sums in another order in another batch."""

_TOLD = {
    "normal_force": (5.0, 30.0),
    "mu_s": (0.45, 0.55),
    "mu_k": (0.28, 0.34),
    "v_b": (0.8, 1.2),
    "rig": (0.0, 0.0),
}
_OTHERS = (1.0, 4.0)
"""What may be told, on the chapter's rig."""


def check_policy(policy: Any, **context: Any) -> None:
    """Raise `ValueError` that says what a policy does against the contract; nothing where it keeps it.

    `policy` is whatever `find_policy` takes: a name, FILE.py:CLASS, a class, or a policy itself. `context` is
    what it is made for, as `context_of` gives it of a task. On observations as they may come (8 steps of 6 rigs)
    it checks that actions have the right shape, are finite and within -1 and 1; that equal observations and
    states give equal actions, so that nothing is kept but in the state; that neither observations nor
    states are changed in place; that a rig's actions do not depend on its company; that an episode's start
    forgets what was before; that what the policy says of itself can be understood; and that it never ends the program.

    >>> check_policy("lqg")
    """
    try:
        scales = Scales.of(context.get("rig"), context.get("largest_reference"))
        _Trial(find_policy(policy).make(**context), scales).run()
    except SystemExit as end:
        name = policy if isinstance(policy, str) else getattr(policy, "__name__", type(policy).__name__)
        raise ValueError(f"{name}: ends the whole program (SystemExit: {end}); allowed: an exception") from end


class _Trial:
    def __init__(self, policy: Policy, scales: Scales) -> None:
        self.policy, self.name = policy, type(policy).__name__
        shown = channels_of(policy)
        random = np.random.default_rng(0)
        shape = (_STEPS, _RIGS, _CHANNELS if shown is None else len(shown))
        self.observations = (0.5 * random.standard_normal(shape)).astype(np.float32)
        grown = {"normal_force": scales.force, "v_b": 1.0 / scales.speed}
        self.told = {
            name: grown.get(name, 1.0) * random.uniform(*_TOLD.get(name, _OTHERS), _RIGS).astype(float)
            for name in privileged_of(policy)
        }
        drive_of(policy)
        is_exact(policy)

    def run(self) -> None:
        everyone = np.arange(_RIGS)
        whole = self._play(everyone)
        for rig in (0, _RIGS - 1):
            alone = self._play(np.array([rig]))
            self._same(alone, whole[:, [rig]], f"acts otherwise on rig {rig} alone than among {_RIGS} rigs")
        order = everyone[::-1].copy()
        self._same(self._play(order), whole[:, order], "acts otherwise where the rigs come in another order")
        again = self._play(everyone, restart=3)
        fresh = self._play(everyone, first=3)
        self._same(again[3:], fresh, "remembers, after an episode's start, what was before")

    def _play(self, rigs: npt.NDArray[np.intp], first: int = 0, restart: int = 0) -> npt.NDArray[np.float64]:
        """Actions of some rigs, shape (steps, rigs); episodes begin at the step `first`, and anew at `restart`."""
        actions, state = [], None
        for step in range(first, _STEPS):
            starts = np.full(len(rigs), step in (first, restart))
            given, state = self._act(self.observations[step, rigs], state, starts, self._info(rigs))
            actions.append(given[:, 0].astype(float))
        return np.array(actions)

    def _info(self, rigs: npt.NDArray[np.intp]) -> Mapping[str, npt.NDArray[np.float64]]:
        return {name: values[rigs] for name, values in self.told.items()}

    def _act(
        self, observation: Observations, state: Memory, starts: npt.NDArray[np.bool_], info: Mapping[str, Any]
    ) -> tuple[Actions, Memory]:
        """One call of `predict`, made twice: the answers must agree, and the arguments be what they were."""
        shown, held = observation.copy(), [np.array(array) for array in state or ()]
        if info:
            self.policy.tell(info)  # type: ignore[attr-defined]
        answers = [self.policy.predict(observation, state, starts, deterministic=True) for _ in range(2)]
        for answer in answers:
            if not isinstance(answer, tuple) or len(answer) != 2:
                raise self._fault(f"predict returns {type(answer).__name__}; allowed: (actions, state)")
        (actions, kept), (repeated, _) = answers
        self._check(actions, len(observation))
        if not np.array_equal(actions, repeated):
            raise self._fault("gives other actions to equal observations and states: it keeps something of its own")
        if not np.array_equal(observation, shown):
            raise self._fault("changes the observations that it is shown, in place")
        if not all(map(np.array_equal, state or (), held)):
            raise self._fault("changes the state that it is given, in place")
        return actions, kept

    def _check(self, actions: Any, rigs: int) -> None:
        if not isinstance(actions, np.ndarray) or actions.shape != (rigs, 1):
            shape = getattr(actions, "shape", type(actions).__name__)
            raise self._fault(f"actions of shape {shape} for {rigs} rigs; allowed: an array of shape ({rigs}, 1)")
        if not np.issubdtype(actions.dtype, np.floating):
            raise self._fault(f"actions of {actions.dtype}; allowed: real numbers, such as float32")
        if not np.all(np.isfinite(actions)) or np.any(np.abs(actions) > 1.0):
            raise self._fault(f"actions {actions[:, 0].tolist()}; allowed: finite, -1 to 1")

    def _same(self, found: npt.NDArray[np.float64], wanted: npt.NDArray[np.float64], fault: str) -> None:
        if np.max(np.abs(found - wanted)) > _ROUNDING:
            raise self._fault(fault)

    def _fault(self, text: str) -> ValueError:
        return ValueError(f"{self.name}: {text}")
