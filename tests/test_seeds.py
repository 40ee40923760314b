"""No rig is trained, tuned or chosen on and then judged on."""

from itertools import pairwise

import pytest

from drillrig_env import seeds
from drillrig_env.evaluation.suites import SUITES, suite
from drillrig_env.seeds import EVALUATION_SEEDS


@pytest.mark.parametrize(("of", "count"), [("_SEEDS", 5), ("_FLEETS", 4)])
def test_ranges_of_seeds_have_none_in_common(of, count):
    ranges = sorted((value for name, value in vars(seeds).items() if name.endswith(of)), key=lambda one: one.start)
    assert len(ranges) >= count  # whatever range is added is among them
    assert ranges[0].start == 0
    for lower, upper in pairwise(ranges):
        assert lower.stop <= upper.start
        assert len(lower) > 0


def test_every_suite_is_drawn_from_the_evaluations_seeds():
    for name in SUITES:
        one = suite(name, 1000)
        assert one.first_seed in EVALUATION_SEEDS
        assert one.first_seed + one.rigs - 1 in EVALUATION_SEEDS
