"""Tables as numbers, on scores made by hand."""

import numpy as np
import pytest

from drillrig_env.evaluation.statistics import difference, mean, median, over_seeds, rate
from drillrig_env.evaluation.tables import (
    DIFFERENCES,
    HARDNESS,
    MAIN,
    Column,
    all_estimates,
    best_first,
    by_rig,
    differences,
    estimates,
    stored_row,
)

RIGS = 8


def scores(seeds=("",), shift=0.0):
    """RIGS episodes a seed; the seed number k adds `shift` k to the numbers."""
    rigs = np.arange(RIGS)
    count = len(seeds)
    numbers = np.concatenate([rigs + shift * k for k in range(count)]).astype(float)
    return {
        "seed": np.repeat(np.array(seeds), RIGS),
        "mitigated": np.concatenate([rigs >= 4 + k for k in range(count)]),
        "calm": np.concatenate([rigs >= 2 for _ in range(count)]),
        "region": np.tile(np.array(["below", "bistable", "above", "above"] * 2), count),
        "hardness": np.tile(np.array([0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 19.0]), count),
        **dict.fromkeys(("time_to_calm", "cost", "stuck", "ssi", "peak_speed", "peak_torque", "travel"), numbers),
    }


def test_a_column_counts_the_rigs_of_its_region_or_bin():
    table = scores()
    assert Column("", "calm").chosen(table).all()
    assert np.flatnonzero(Column("", "calm", region="bistable").chosen(table)).tolist() == [1, 5]
    assert np.flatnonzero(Column("", "calm", hardness=(1.0, 2.0)).chosen(table)).tolist() == [2, 3]
    assert np.flatnonzero(Column("", "calm", region="above", hardness=(1.0, 2.0)).chosen(table)).tolist() == [2, 3]


def test_bins_of_hardness_are_those_of_the_page():
    assert " ".join(HARDNESS.headings) == "q 0-1 q 1-2 q 2-3 q 3-4 q 4-6 q ≥ 6"


def test_bins_of_hardness_share_the_rigs_out():
    chosen = np.stack([column.chosen(scores()) for column in HARDNESS.columns])
    assert (chosen.sum(axis=0) == 1).all()
    assert chosen.sum(axis=1).tolist() == [2, 2, 1, 1, 1, 1]


@pytest.mark.parametrize("q", [0.0, np.nextafter(1.0, 0.0), 1.0, 6.0, 20.0, 20.9863, 1e6])
def test_every_rig_is_in_one_bin_of_hardness(q):
    assert sum(int(column.chosen(scores() | {"hardness": np.full(RIGS, q)}).all()) for column in HARDNESS.columns) == 1


def test_one_seed_is_estimated_over_rigs():
    row = estimates(scores())
    assert list(row) == MAIN.headings
    assert row["mitigated"] == rate(np.arange(8) >= 4)
    assert row["below ω_c"] == rate(np.array([False, True]))
    assert row["to calm"] == median(np.arange(8.0))


@pytest.mark.parametrize("seeds", [("0", "1"), ("0", "1", "2")])
def test_two_and_more_seeds_are_estimated_over_seeds(seeds):
    table = scores(seeds, shift=1.0)
    found = Column("", "time_to_calm", median).estimate(table)
    assert found == over_seeds([3.5 + k for k in range(len(seeds))], RIGS * len(seeds))
    shares = Column("", "mitigated").estimate(table)
    assert shares == over_seeds([0.5 - k / 8 for k in range(len(seeds))], RIGS * len(seeds))


def test_scores_by_rig_keep_the_order_of_the_seeds():
    found = by_rig(scores(("7", "3"), shift=100.0), "cost")
    np.testing.assert_array_equal(found, [np.arange(8.0), np.arange(8.0) + 100.0])


def test_differences_are_paired_rig_by_rig():
    ours, theirs = scores(), scores()
    theirs = {**theirs, "cost": theirs["cost"][::-1], "calm": ~theirs["calm"]}
    row = differences(ours, theirs)
    assert list(row) == DIFFERENCES.headings
    assert row["cost"] == difference(np.arange(8.0), np.arange(8.0)[::-1])
    assert row["calm"].value == (6 - 2) / 8
    assert row["mitigated"].value == 0.0


def test_differences_of_several_seeds_are_estimated_over_seeds_and_a_reference_is_its_mean():
    ours, theirs = scores(("0", "1"), shift=2.0), scores(("5", "6", "7"), shift=3.0)
    assert differences(ours, scores())["cost"] == over_seeds([0.0, 2.0], 16)
    assert differences(scores(), theirs)["cost"] == mean(np.full(8, -3.0))


def ranked(**shares):
    """Scores of policies by their shares of mitigated and calm rigs, in quarters."""
    return {
        name: {"mitigated": np.arange(4) < mitigated, "calm": np.arange(4) < calm}
        for name, (mitigated, calm) in shares.items()
    }


def test_best_comes_first_among_equals_the_calmer_and_then_by_name():
    assert best_first(ranked(a=(1, 4), b=(3, 3), c=(3, 4), e=(2, 2), d=(2, 2))) == ["c", "b", "d", "e", "a"]


def test_all_estimates_have_differences_from_the_reference_and_losses_from_oneself():
    results = {"default": {"plain": scores(), "other": scores()}, "degraded": {"other": scores(), "new": scores()}}
    found = all_estimates(results, "plain")
    assert set(found["default"]["plain"]) == {"main", "hardness", "others"}
    assert set(found["default"]["other"]) == {"main", "hardness", "others", "differences"}
    assert set(found["degraded"]["other"]) == {"main", "hardness", "others", "loss"}
    assert set(found["degraded"]["new"]) == {"main", "hardness", "others"}
    assert found["default"]["plain"]["main"]["calm"] == vars(rate(np.arange(8) >= 2))
    assert found["degraded"]["other"]["loss"]["cost"]["value"] == 0.0


def test_estimates_come_back_as_they_were_stored():
    row = estimates(scores())
    stored = {heading: vars(estimate) for heading, estimate in row.items()}
    assert stored_row(stored) == row
    nothing = stored_row({"x": {"value": None, "low": None, "high": None, "count": 0}})["x"]
    assert np.isnan([nothing.value, nothing.low, nothing.high]).all()
    assert nothing.count == 0
