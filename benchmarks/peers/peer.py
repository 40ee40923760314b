"""What a solver must offer to be compared: a way to prepare one rig's run, and perhaps a batch's."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec
from typing import Any, NamedTuple, TypeAlias, TypeVar

from benchmarks.case import Rigs
from drillrig_env.arrays import FloatArray
from drillrig_env.parameters import closest

Run: TypeAlias = Callable[[], FloatArray]
"""Solves, with everything compiled before; the states at all sample times, the start among them."""


class Setting(NamedTuple):
    """How accurate a solver shall be: relative and absolute tolerance of a step.

    The project has one number instead, the error of the speeds (rad/s); it stands in `rtol`.
    """

    rtol: float
    atol: float

    @property
    def label(self) -> str:
        """The setting in a table."""
        return f"rtol {self.rtol:.0e}, atol {self.atol:.0e}" if self.atol else f"tolerance {self.rtol:.0e} rad/s"


def settings(*rtols: float, ratio: float = 1e-3) -> tuple[Setting, ...]:
    """Settings whose absolute tolerance is `ratio` of the relative one: the stick zone is 1e-3 rad/s wide."""
    return tuple(Setting(rtol, ratio * rtol) for rtol in rtols)


@dataclass(frozen=True)
class Library:
    """Where a solver comes from."""

    name: str
    module: str
    install: str
    """Its name for `pip install`."""

    @property
    def found(self) -> bool:
        """Whether it is installed."""
        return find_spec(self.module) is not None

    @property
    def hint(self) -> str:
        """What to tell where it is not."""
        return f"{self.name} is left out; install it with: pip install {self.install}"

    @property
    def version(self) -> str:
        """Its installed version."""
        return version(self.install)


@dataclass(frozen=True)
class Solver:
    """What one rig's solvers and a batch's have in common."""

    package: Library
    method: str
    form: str
    """What it gets: the language of the right-hand side, a Jacobian, events."""
    settings: tuple[Setting, ...]

    @property
    def name(self) -> str:
        """The solver in a table."""
        return f"{self.package.name} {self.method}"

    def described(self, setting: Setting) -> dict[str, Any]:
        """The solver at one setting, before it is measured."""
        return {
            "solver": self.name,
            "library": self.package.name,
            "version": self.package.version,
            "form": self.form,
            "setting": setting.label,
            "rtol": setting.rtol,
            "atol": setting.atol,
        }


@dataclass(frozen=True)
class Peer(Solver):
    """A solver for one rig. `prepare(setting, times)` compiles all that can be; the run gives (samples, 7)."""

    prepare: Callable[[Setting, FloatArray], Run]


@dataclass(frozen=True)
class BatchPeer(Solver):
    """A solver for many rigs. `prepare(rigs, setting, times, threads)`; the run gives (rigs, samples, 7)."""

    prepare: Callable[[Rigs, Setting, FloatArray, int], Run]
    one_core: bool = False
    """Whether it shall keep to one core rather than use all."""
    duration: float = 10.0
    """Motion that it is given, s: less where it is too slow for more."""


S = TypeVar("S", bound=Solver)


def left_out(solvers: Iterable[Solver]) -> list[str]:
    """A hint for each library that is not installed."""
    return sorted({solver.package.hint for solver in solvers if not solver.package.found})


def asked_for(solvers: Iterable[S], only: Sequence[str]) -> list[S]:
    """The solvers that are installed, and have one of the names `only` in theirs if there are any.

    `ValueError` for a name that no solver has, or only such as are not installed.
    """
    known = list(solvers)
    for name in only:
        named = [solver for solver in known if name.lower() in solver.name.lower()]
        if not named:
            names = [solver.name for solver in known]
            raise ValueError(f"--only: no solver has {name!r} in its name; {closest(name, names)}")
        if not any(solver.package.found for solver in named):
            raise ValueError(f"--only {name}: {named[0].package.hint}")
    return [
        solver
        for solver in known
        if solver.package.found and (not only or any(name.lower() in solver.name.lower() for name in only))
    ]
