"""What the source chapter prints and states, beside what the model gives: the checks of docs/validation.md."""

from drillrig_env.validation.check import Check
from drillrig_env.validation.out_of_reach import OUT_OF_REACH
from drillrig_env.validation.topics import all_checks

__all__ = ["OUT_OF_REACH", "Check", "all_checks"]
