import numpy as np
import pytest

from baselines.hindsight import in_words, main, settings_around, tried
from baselines.lqg import LQG
from baselines.tune import measure, tuning_suite


def test_settings_begin_with_the_tuned_ones_and_keep_within_the_bounds():
    settings = settings_around("lqg", "surface", 20, seed=1)
    assert settings[0] == LQG.tuned_values["surface"]
    assert len({tuple(values.values()) for values in settings}) == 20
    assert all(low <= values[name] <= high for values in settings for name, (low, high) in LQG.tuned.items())
    assert settings == settings_around("lqg", "surface", 20, seed=1)


def test_each_setting_is_run_as_tuning_runs_it():
    suite, settings = tuning_suite("default", 20), settings_around("z_torque", "surface", 2)
    hardness, mitigated = tried("z_torque", "surface", settings, suite)
    assert hardness.shape == (20,)
    for values, found in zip(settings, mitigated, strict=True):
        assert found.mean() == measure("z_torque", values, "surface", suite)["mitigated"]


def test_the_best_of_each_rig_is_no_worse_than_the_best_setting():
    found = in_words(np.array([0.5, 1.5, 1.6]), np.array([[1, 0, 0], [0, 1, 1], [1, 0, 1]], dtype=bool))
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in found.splitlines()[2:]]
    assert [row[:4] for row in rows] == [
        ["tuned", "0.333", "1.000", "0.000"],
        ["best of 3 settings", "0.667", "0.000", "1.000"],
        ["each rig's best", "1.000", "1.000", "1.000"],
    ]


def test_sensors_without_tuned_values_are_refused():
    with pytest.raises(ValueError, match="soft_torque has no tuned values for the sensors encoders"):
        settings_around("soft_torque", "encoders", 3)


def test_the_command_prints_the_table(capsys):
    main(["z_torque", "--rigs", "10", "--settings", "2"])
    assert "each rig's best" in capsys.readouterr().out
