import json

import numpy as np
import pytest

from baselines import BASELINES
from baselines.tune import keep, measure, search, tuning_suite
from baselines.tuned import RECORD
from drillrig_env.seeds import EVALUATION_SEEDS, TUNING_SEEDS

ENTRIES = json.loads(RECORD.read_text(encoding="utf-8"))


def test_all_tuned_values_are_on_record_and_from_training_seeds():
    kept = {(entry["controller"], sensors) for entry in ENTRIES for sensors in entry["sensors"]}
    assert kept == {(name, sensors) for name, kind in BASELINES.items() for sensors in kind.tuned_values}
    for entry in ENTRIES:
        assert entry["first_seed"] in TUNING_SEEDS
        assert entry["first_seed"] + entry["rigs"] + entry["fresh_rigs"] - 1 in TUNING_SEEDS


def test_search_is_repeatable_and_better_than_a_bad_gain():
    suites = [tuning_suite("default", 12)]
    found = search("soft_torque", ["state"], suites, budget=24)
    assert found == search("soft_torque", ["state"], suites, budget=24)
    worst = {"proportional": 0.6, "integral": 0.5}
    best, bad = (measure("soft_torque", values, "state", suites[0]) for values in (found, worst))
    assert best["mitigated"] > bad["mitigated"]


def test_tuning_suite_keeps_off_the_seeds_of_the_evaluation():
    assert tuning_suite("load", 10).first_seed == TUNING_SEEDS.start
    with pytest.raises(ValueError, match="tune: first seed = 999999999 is not allowed"):
        tuning_suite("default", 10, EVALUATION_SEEDS.start - 1)


def test_an_entry_takes_the_place_of_an_earlier_one_for_the_same_sensors(tmp_path):
    record = tmp_path / "tuned.json"
    keep(record, {"controller": "a", "sensors": ["state"], "values": {"gain": 1.0}})
    keep(record, {"controller": "a", "sensors": ["surface"], "values": {"gain": 2.0}})
    keep(record, {"controller": "a", "sensors": ["state"], "values": {"gain": 3.0}})
    gains = [entry["values"]["gain"] for entry in json.loads(record.read_text(encoding="utf-8"))]
    np.testing.assert_array_equal(gains, [2.0, 3.0])


def test_a_controller_without_gains_is_refused():
    with pytest.raises(ValueError, match=r"'constant' has no gains to tune; .*allowed: .*z_torque"):
        search("constant", ["state"], [tuning_suite("default", 2)], budget=10)
