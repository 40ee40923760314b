"""The results and the agent that pages are made from, as the rooms that they belong to have them."""

from tests.agents.conftest import five_seeds, trained
from tests.evaluation.conftest import comparison

__all__ = ["comparison", "five_seeds", "trained"]
