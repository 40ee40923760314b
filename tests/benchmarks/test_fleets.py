"""The benchmark of fleets: what it compares, and its table."""

import numpy as np
import pytest

from benchmarks.fleets import FACTORS, ONE, Batch, by_itself, fleet_of, main, measure, seconds_to_build
from drillrig_env import Fleet, Rig
from drillrig_env.stepper.ladder import LADDER


@pytest.mark.slow
def test_every_run_goes_on_from_the_same_moment():
    batch = Batch.of(6, fleet_of(next(iter(FACTORS)), 3))
    seen = []
    for _ in range(2):
        assert batch.seconds(3) > 0.0
        seen.append(batch.env.core.episodes.copy())
    np.testing.assert_array_equal(*seen)
    assert batch.bytes_per_rig == LADDER.itemsize


def test_rigs_that_need_the_shortest_steps_are_counted():
    """An armature without inductance needs them to land on a kink, which the start in stick-slip has led across."""
    assert Batch.of(4, Fleet(rigs=(Rig(), Rig(J_1=0.05)))).with_shortest == 0
    assert Batch.of(4, Fleet(rigs=(Rig(), Rig(L=1e-9)))).with_shortest == 1


@pytest.mark.parametrize("kind", FACTORS)
def test_building_takes_time_and_gives_as_many_rigs(kind):
    assert seconds_to_build(kind, 2, 2) > 0.0
    assert len(fleet_of(kind, 5).members().rigs) == 5


def test_every_kind_of_batch_is_in_the_table_once(capsys):
    rows = measure(2, 2, 1, 1)
    assert [row[0] for row in rows] == [ONE, *FACTORS, *map(by_itself, FACTORS)]
    assert rows[0][-1] == "1.00"
    assert main(["--quick", "--rigs", "2", "--episodes", "2", "--repeats", "1"]) in (None, 0)
    printed = capsys.readouterr().out
    assert f"| within a factor of 1.1 | {LADDER.itemsize / 1e3:.1f} kB |" in printed
    assert "4 episodes. " in printed
