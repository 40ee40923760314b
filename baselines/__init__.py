"""Policies from the physics, each with Stable-Baselines3's `predict`.

Each works from what the sensors show; one that must be told more says so in `privileged`.

Which of them must be told what no sensor shows, and what two of them do with twenty rigs in stick-slip:

>>> from baselines import FeedForwardStart, JumpEase, JumpEaseEstimated, SoftTorque, SpeedPulse, Constant, MPPI
>>> [law.__name__ for law in (FeedForwardStart, JumpEase, MPPI) if law().privileged]
['FeedForwardStart', 'JumpEase', 'MPPI']
>>> [law.__name__ for law in (Constant, JumpEaseEstimated, SoftTorque, SpeedPulse) if law().privileged]
[]
>>> from drillrig_env.evaluation.runner import run
>>> from drillrig_env.evaluation.scores import score
>>> from drillrig_env.evaluation.suites import suite
>>> rigs = suite("default", rigs=20)
>>> [round(float(score(run(law(), rigs))["mitigated"].mean()), 2) for law in (Constant, SoftTorque)]
[0.4, 1.0]
"""

from __future__ import annotations

from typing import Any

from baselines.baseline import Baseline
from baselines.constant import Constant
from baselines.feed_forward_start import FeedForwardStart
from baselines.jump_ease import JumpEase
from baselines.jump_ease_estimated import JumpEaseEstimated
from baselines.lqg import LQG
from baselines.mppi import MPPI
from baselines.soft_torque import SoftTorque
from baselines.speed_pulse import SpeedPulse
from baselines.z_torque import ZTorque
from drillrig_env.parameters import closest

BASELINES: dict[str, type[Baseline]] = {
    "constant": Constant,
    "jump_ease": JumpEase,
    "jump_ease_estimated": JumpEaseEstimated,
    "z_torque": ZTorque,
    "soft_torque": SoftTorque,
    "speed_pulse": SpeedPulse,
    "feed_forward_start": FeedForwardStart,
    "lqg": LQG,
    "mppi": MPPI,
}
"""Every baseline by name."""

__all__ = [
    "BASELINES",
    "LQG",
    "MPPI",
    "Baseline",
    "Constant",
    "FeedForwardStart",
    "JumpEase",
    "JumpEaseEstimated",
    "SoftTorque",
    "SpeedPulse",
    "ZTorque",
    "make",
]


def make(name: str, **kwargs: Any) -> Baseline:
    """A baseline by name; `kwargs` as for its class. `ValueError` for an unknown name.

    >>> from baselines import make
    >>> make("lqg", delay=3).delay
    3
    """
    if name not in BASELINES:
        raise ValueError(f"baseline {name!r} is not known; {closest(name, BASELINES)}")
    return BASELINES[name](**kwargs)
