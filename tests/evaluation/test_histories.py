"""Histories: which rigs are kept, and that they come back as they were."""

import io

import numpy as np
import pytest

from drillrig_env.evaluation.histories import Histories, times, typical_rigs, worth_showing


def test_histories_come_back(comparison):
    _, histories = comparison
    again = Histories.unpacked(histories.packed())
    assert again.kept.keys() == histories.kept.keys()
    for key, history in histories.kept.items():
        for name, values in history.items():
            np.testing.assert_array_equal(again.kept[key][name], values)
    assert again.packed() == histories.packed()
    assert Histories.unpacked(Histories().packed()).kept == {}


def test_typical_rigs_are_chosen_by_the_physics(comparison):
    results, histories = comparison
    scores = results.scores["default"]
    rigs = [typical_rigs(scores[policy]) for policy in ("constant", "privileged")]
    assert rigs[0] == rigs[1]
    for region, rig in rigs[0].items():
        assert scores["constant"]["region"][rig] == region
        for suite in ("default", "load"):
            found = histories.of(suite, region)
            assert list(found) == ["constant", "privileged", "seeds"]
            assert all(history is histories.kept[suite, policy, region] for policy, history in found.items())


def test_a_typical_rig_is_the_one_of_median_hardness():
    regions = np.array(["below", "below", "above", "below", "bistable"])
    assert typical_rigs(
        {"seed": np.full(5, ""), "region": regions, "hardness": np.array([3.0, 1.0, 9.0, 2.0, 1.5])}
    ) == {
        "below": 3,
        "bistable": 4,
    }
    assert typical_rigs({"seed": np.array([""]), "region": np.array(["above"]), "hardness": np.array([0.5])}) == {}
    hardness = np.array([5.0, 1.0, 4.0, 2.0, 3.0, 6.0])
    for count, middle in ((1, 5.0), (2, 5.0), (4, 4.0), (5, 3.0), (6, 4.0)):  # of an even number, the harder one
        found = typical_rigs(
            {"seed": np.full(count, ""), "region": np.full(count, "below"), "hardness": hardness[:count]}
        )
        assert hardness[found["below"]] == middle


def test_times_are_the_ends_of_control_steps():
    np.testing.assert_allclose(times({"average": np.zeros(3, np.float32)}), [0.1, 0.2, 0.3])


def test_file_with_pickled_objects_is_refused():
    """Loading a pickle executes what is in it; histories are numbers only."""
    buffer = io.BytesIO()
    np.savez(buffer, **{"default|a|below": np.array([{}], dtype=object)})
    with pytest.raises(ValueError, match="pickle"):
        Histories.unpacked(buffer.getvalue())


def test_action_zero_and_the_best_of_those_kept_are_worth_showing():
    calm = np.ones(10, dtype=bool)
    results = {
        name: {"mitigated": np.arange(10) < count, "calm": calm}
        for name, count in zip(["a", "b", "constant", "d", "e", "f"], range(6), strict=True)
    }
    assert worth_showing(results, ["a", "b", "constant", "d", "e"]) == ["constant", "e", "d", "b"]
    assert worth_showing(results, ["a", "f", "constant"]) == ["constant", "f", "a"]
    assert worth_showing(results, ["e", "f", "a"], most=2) == ["f", "e"]
    assert worth_showing(results, ["a"]) == ["a"]
