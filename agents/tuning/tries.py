"""What Optuna keeps of a try, read as what a study is about: worth and steps."""

from __future__ import annotations

from typing import Any

STEPS = "steps"
"""The attribute of a try that says how many steps of the environment it took."""


def worth(trial: Any) -> float:
    """What a try was worth when it was looked at last."""
    if trial.intermediate_values:
        return float(trial.intermediate_values[max(trial.intermediate_values)])
    return float(trial.value)


def steps_of(trial: Any) -> int:
    """How many steps of the environment a try took."""
    return int(trial.user_attrs.get(STEPS, 0))
