"""What counts as a number that was measured."""

import numpy as np
import pytest

from drillrig_env.deploy.checks import last_number


@pytest.mark.parametrize(
    ("value", "number"),
    [
        (3.5, 3.5),
        (3, 3.0),
        (np.float32(0.5), 0.5),
        ([1.0, 2.0], 2.0),
        (np.array([1.0, 4.0]), 4.0),
        ("31", None),
        ("x", None),
        (True, None),
        ([1.0, True], None),
        ([1.0, float("nan")], None),
        ([float("inf"), 1.0], None),
        ([], None),
        (None, None),
        (float("nan"), None),
        ({"a": 1.0}, None),
    ],
)
def test_the_last_sample_counts_and_only_where_all_are_numbers(value, number):
    assert last_number(value) == number
