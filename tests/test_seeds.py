"""No rig is trained, tuned or chosen on and then judged on."""

from itertools import pairwise

from drillrig_env.evaluation.suites import SUITES, suite
from drillrig_env.seeds import DATASET_SEEDS, EVALUATION_SEEDS, TRAINING_SEEDS, TUNING_SEEDS, VALIDATION_SEEDS


def test_ranges_of_seeds_have_none_in_common():
    every = (TRAINING_SEEDS, TUNING_SEEDS, VALIDATION_SEEDS, EVALUATION_SEEDS, DATASET_SEEDS)
    ranges = sorted(every, key=lambda one: one.start)
    assert ranges[0].start == 0
    for lower, upper in pairwise(ranges):
        assert lower.stop <= upper.start
        assert len(lower) > 0


def test_every_suite_is_drawn_from_the_evaluations_seeds():
    for name in SUITES:
        one = suite(name, 1000)
        assert one.first_seed in EVALUATION_SEEDS
        assert one.first_seed + one.rigs - 1 in EVALUATION_SEEDS
