"""Whether two processes compute the same: their versions, and the digest of their kernels; and on which processor."""

from __future__ import annotations

import platform
import sys
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from drillrig_env.command_line import Failed
from drillrig_env.jit.stamp import stamp_of

_PACKAGES = ("numpy", "scipy", "numba", "gymnasium", "stable-baselines3", "torch")
_KERNELS = ("stepper/batch.py", "env/kernel.py")
"""Files on which all that is simulated stands, from the top of the package."""


@cache
def likeness() -> Mapping[str, str]:
    """What must be the same for the same bits: the project, its kernels, Python and the packages that compute."""
    top = Path(__file__).parents[1]
    kernels = "".join(stamp_of(str(top / file)) for file in _KERNELS)
    return {
        "drillrig": sys.modules[top.name].__version__,  # the package itself, in which this is
        "kernels": f"{kernels[:8]}{kernels[-8:]}",
        "Python": platform.python_version(),
        **{package: _version(package) for package in _PACKAGES},
    }


def check_alike(wanted: Mapping[str, str], where: str) -> None:
    """Raise `Failed`, naming what differs, where this process has another likeness than the one that is `wanted`."""
    own = likeness()
    differs = [f"{name} {own[name]} and not {wanted[name]}" for name in wanted if own[name] != wanted[name]]
    if differs:
        raise Failed(
            f"{where} does not compute as the machine that asks it: it has {', '.join(differs)}; "
            "install the same version of the project and its packages on all machines"
        )


@cache
def processor() -> str:
    """The processor by its trade name where the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "processor unknown"


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "missing"
