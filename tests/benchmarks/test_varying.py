"""The comparison of scenarios that vary runs, with what it compares at rest the same as without."""

import numpy as np
import pytest

from benchmarks.varying import main, scenarios
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms


def test_the_table_has_a_row_for_each_scenario(capsys):
    main(["--rigs", "4", "--repeats", "1"])
    table = capsys.readouterr().out
    assert all(name in table for name in scenarios())
    assert "1.00" in table


@pytest.mark.parametrize("name", [name for name in scenarios() if "at rest" in name])
def test_what_is_at_rest_changes_nothing(name):
    states = []
    for scenario in (scenarios()["nothing varies"], scenarios()[name]):
        batch = EpisodeBatch(8, scenario=scenario)
        batch.reset(np.arange(8), first_uniforms(0, 8))
        for _ in range(30):
            batch.step(np.ones((8, 1), np.float32))
        states.append(batch.episodes["state"][:, :7].copy())
    np.testing.assert_allclose(*states, atol=1e-5)
