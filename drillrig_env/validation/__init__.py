"""What the source chapter prints and states, beside what the model gives: the page docs/validation.md."""

from drillrig_env.validation.check import Check
from drillrig_env.validation.page import all_checks, page

__all__ = ["Check", "all_checks", "page"]
