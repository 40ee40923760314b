"""Terms of the reward of the user's own: a function of what the episode says at the end of a control step.

    from drillrig_env import RewardTerms

    def smooth_drive(string_torque_highest, action):
        return -max(string_torque_highest - 0.6, 0.0), -0.05 * abs(action)

    env = gym.make("DrillRig-v0", reward=RewardTerms(("peak", "effort"), smooth_drive))

The names of the function's arguments say what it is given: `action`, and those of
`drillrig_env.env.quantities.ENTRIES`. Compiled, it gets plain numbers, and kernels call it by the address of its
machine code: they need not be compiled for it. Left to Python, it gets arrays with an entry a rig.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from math import nan
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.env.quantities import BY_NAME
from drillrig_env.modules import found_in, is_place
from drillrig_env.parameters import closest, refuse
from drillrig_env.stepper.finite import NotFiniteError

TERMS = ("variance", "tracking", "action")
"""Names of the default reward's terms, in the order of `drillrig_env.env.reward_kernel.reward_terms`."""

MOST_TERMS = 8
"""Most terms of the user's own."""

ACTION = "action"
"""The one argument that no record holds: the action, -1 to 1."""


@dataclass(frozen=True)
class RewardTerms:
    """Named terms of a reward: a function that gives a number for each of `names`, or one number for one name.

    Its arguments are found by their names; others must have a default, which they keep. `compiled`, it is a function of
    numbers, plain or compiled by Numba; otherwise Python calls it once a control step with arrays of shape (rigs,),
    and it returns such arrays. `source` is "file.py:name" of terms that were read from there. A pickle holds that, or
    else the function, which then must be importable.

    Raises `ValueError` for names that are taken, a function that cannot be compiled, an argument that nothing is known
    of, and for another number of terms than names.

    >>> import gymnasium as gym
    >>> from drillrig_env import Reward, RewardTerms
    >>> wear = RewardTerms("wear", lambda string_torque_highest: -0.1 * string_torque_highest**2)
    >>> env = gym.make("DrillRig-v0", reward=Reward(own=wear))
    >>> _ = env.reset(seed=0)
    >>> "reward_wear" in env.step(env.action_space.sample())[-1]
    True
    """

    names: tuple[str, ...]
    function: Callable[..., Any]
    compiled: bool = True
    source: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        names = (self.names,) if isinstance(self.names, str) else self.names
        if not isinstance(names, Sequence) or not all(isinstance(name, str) and name.isidentifier() for name in names):
            raise refuse("RewardTerms", "names", repr(names), "", "words such as torque")
        if not 0 < len(names) <= MOST_TERMS or len(set(names)) < len(names) or set(names) & set(TERMS):
            allowed = f"1 to {MOST_TERMS} different names, none of them {', '.join(TERMS)}"
            raise refuse("RewardTerms", "names", tuple(names), "", allowed)
        object.__setattr__(self, "names", tuple(names))
        if not isinstance(self.compiled, bool):
            raise refuse("RewardTerms", "compiled", repr(self.compiled), "", "True or False")
        from drillrig_env.jit.compiled import is_compilable  # a default reward needs no compiler

        if not (is_compilable(self.function) if self.compiled else callable(self.function)):
            allowed = "a function of what an episode says; with compiled=False whatever can be called"
            raise refuse("RewardTerms", "function", repr(self.function), "", allowed)
        self.arguments  # noqa: B018  says which is not known
        if self.compiled:
            address_of(self)

    def __reduce__(self) -> tuple[Any, ...]:
        if self.source:
            return RewardTerms.from_file, (self.source,)
        return RewardTerms, (self.names, self.function, self.compiled)

    def __deepcopy__(self, _memo: Any) -> RewardTerms:
        return self

    def __str__(self) -> str:
        return self.source or ", ".join(self.names)

    @classmethod
    def of(cls, given: Any) -> RewardTerms:
        """Terms as a reward takes them: themselves, or "file.py:name". `ValueError` for anything else.

        `given` is either of them.
        """
        if isinstance(given, cls):
            return given
        if is_place(given):
            return cls.from_file(given)
        raise ValueError(f"{given!r} is not known; allowed: RewardTerms, or file.py:name of some")

    @classmethod
    def from_file(cls, source: str) -> RewardTerms:
        """The terms that a Python file holds under a name: "file.py:name". `ValueError` where there are none.

        `source` is file and name.
        """
        return replace(found_in(source, cls, "reward"), source=source)

    @cached_property
    def arguments(self) -> tuple[str, ...]:
        """What the function is given, by name."""
        function: Any = self.function
        found = []
        for name, parameter in inspect.signature(getattr(function, "py_func", function)).parameters.items():
            if parameter.kind not in (parameter.POSITIONAL_OR_KEYWORD, parameter.KEYWORD_ONLY):
                raise refuse("RewardTerms", "argument", str(parameter), "", "arguments by name")
            if name in BY_NAME or name == ACTION:
                found.append(name)
            elif parameter.default is parameter.empty:
                raise ValueError(f"RewardTerms: unknown argument {name!r}; {closest(name, (*BY_NAME, ACTION))}")
        return tuple(found)

    def values(self, episodes: np.ndarray, actions: npt.NDArray[np.float32]) -> FloatArray:
        """What a function in Python makes of n records and `actions` of shape (n, 1); shape (n, terms).

        `episodes` are the records, of EPISODE, shape (n,).

        Raises `ValueError` for another number or shape of terms.
        """
        rigs = len(episodes)
        given = {name: BY_NAME[name].of(episodes) for name in self.arguments if name != ACTION}
        if ACTION in self.arguments:
            given[ACTION] = np.clip(actions[:, 0].astype(float), -1.0, 1.0)
        found = self.function(**given)
        if len(self.names) == 1 and not isinstance(found, tuple | list):
            found = (found,)
        if not isinstance(found, tuple | list) or len(found) != len(self.names):
            count = len(found) if isinstance(found, tuple | list) else repr(found)
            raise refuse("RewardTerms", "number of terms", count, "", f"one for each of {', '.join(self.names)}")
        values = np.empty((rigs, len(found)))
        for column, name, term in zip(values.T, self.names, found, strict=True):
            array = np.asarray(term)
            if array.dtype.kind not in "iuf" or array.shape not in ((), (rigs,)):
                given_as = f"{array.dtype} of shape {array.shape}"
                raise refuse("RewardTerms", f"term {name}", given_as, "", f"numbers of shape ({rigs},)")
            column[:] = array
        return values

    def add_to(
        self, episodes: np.ndarray, actions: npt.NDArray[np.float32], moved: npt.NDArray[np.bool_] | None = None
    ) -> int:
        """Add the terms of a function in Python to the rewards of those that `moved` (n,); how many are not finite.

        `episodes` are n records of EPISODE, in place; `actions` have the shape (n, 1).
        """
        chosen = slice(None) if moved is None else moved
        values = self.values(episodes, actions)[chosen]
        episodes["own_terms"][chosen, : len(self.names)] = values
        for term in values.T:
            episodes["reward"][chosen] += term
        return int(np.count_nonzero(~np.isfinite(values).all(axis=1)))

    def check_finite(self, values: FloatArray, times: FloatArray, seeds: Sequence[int | None]) -> None:
        """Raise `NotFiniteError` for the first rig with a term that is not finite.

        `values` has shape (n, terms or more), `times` (s) has shape (n,), and `seeds` holds the seed of each rig by its
        number, where they have one.
        """
        wrong = np.argwhere(~np.isfinite(values[:, : len(self.names)]))
        for rig, i in wrong[:1].tolist():
            seed = f" (seed {seeds[rig]})" if rig < len(seeds) and seeds[rig] is not None else ""
            raise NotFiniteError(
                f"step: term {self.names[i]} of the reward = {values[rig, i]} of rig {rig}{seed} at {times[rig]:g} s "
                "is not allowed; allowed: finite numbers"
            )


def address_of(terms: RewardTerms) -> int:
    """The address of the machine code of compiled terms, which stays where it is for as long as the process lives."""
    return int(_machine_code(terms).address)


@cache
def _machine_code(terms: RewardTerms) -> Any:
    import numba

    from drillrig_env.env.episode import EPISODE
    from drillrig_env.jit.compiled import NOT_COMPILED, reason_of

    compiler: Any = numba  # whose types say little of what it makes
    types = compiler.types
    record = compiler.from_dtype(EPISODE)
    given: Any = terms.function
    function = given if hasattr(given, "py_func") else compiler.njit(error_model="numpy")(given)
    reads = (f"{name}={ACTION if name == ACTION else BY_NAME[name].expression}" for name in terms.arguments)
    ask = compiler.njit(error_model="numpy")(
        _made("ask", ["episode, action", f"return function({', '.join(reads)})"], function=function)
    )
    try:
        ask.compile((record, types.float64))
        found = ask.overloads[record, types.float64].signature.return_type
        several = isinstance(found, types.BaseTuple)
        kinds = tuple(found) if several else (found,)
        if not all(isinstance(kind, types.Integer | types.Float) for kind in kinds):
            raise refuse("RewardTerms", "what the function returns", found, "", "a number for each name")
        if len(kinds) != len(terms.names):
            raise refuse("RewardTerms", "number of terms", len(kinds), "", f"one for each of {', '.join(terms.names)}")
        unknown = [f"episode.own_terms[{i}] = nan" for i in range(len(kinds))]  # stay where the function raises
        keep = [f"episode.own_terms[{i}] = found{f'[{i}]' if several else ''}" for i in range(len(kinds))]
        lines = ["place, action", "episode = carray(place, 1)[0]", *unknown, "found = ask(episode, action)", *keep]
        evaluate = _made("evaluate", lines, carray=compiler.carray, ask=ask, nan=nan)
        return compiler.cfunc(types.void(types.CPointer(record), types.float64), error_model="numpy")(evaluate)
    except NOT_COMPILED as error:
        reason = f"{reason_of(error)}; compiled=False leaves it to Python"
        raise ValueError(f"RewardTerms {terms}: the function cannot be compiled: {reason}") from error


def _made(name: str, lines: Sequence[str], **known: Any) -> Callable[..., Any]:
    """A function of some lines, its arguments first, written for the names that another one asks for."""
    arguments, *body = lines
    exec("\n    ".join((f"def {name}({arguments}):", *body)), known)
    made: Callable[..., Any] = known[name]
    return made
