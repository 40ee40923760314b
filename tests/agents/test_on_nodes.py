"""Trainings and tries of a study by two machines, of which one is killed in the midst: the bits of one process."""

import os

import pytest

from agents.policy.run_folder import CHECKPOINT
from agents.training.seeds import train_seeds
from agents.tuning import search
from agents.tuning.study import JOURNAL, Study
from drillrig_env.engine import Local
from drillrig_env.engine.on_ray import OnRay
from tests.agents.test_seeds import same_weights, small
from tests.agents.test_tuning import question
from tests.engine.nodes import two_nodes

pytest.importorskip("ray.cluster_utils")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name == "nt", reason="signals")]


def test_seeds_end_with_the_bits_of_trainings_here(tmp_path):
    train_seeds(small(tmp_path / "here", n_timesteps=4096, save_freq=256), 2)
    begun = [tmp_path / "nodes" / f"seed_{seed}" / CHECKPOINT for seed in (0, 1)]
    with two_nodes() as (cluster, kill_when), OnRay(cluster.address) as engine:
        kill_when(lambda: all(checkpoint.is_file() for checkpoint in begun))
        train_seeds(small(tmp_path / "nodes", n_timesteps=4096, save_freq=256), 2, engine)
        assert not cluster.worker_nodes
    for seed in ("seed_0", "seed_1"):
        assert same_weights(tmp_path / "nodes" / seed, tmp_path / "here" / seed)


def test_a_study_has_all_its_tries(tmp_path):
    asked, journal = question(tmp_path, objective="reward"), tmp_path / "nodes" / JOURNAL
    search.search(tmp_path / "here", asked, 1000, None, Local(), lambda line: None)
    with two_nodes() as (cluster, kill_when), OnRay(cluster.address) as engine:
        kill_when(lambda: journal.is_file() and '"step"' in journal.read_text())
        search.search(tmp_path / "nodes", asked, 4000, None, engine, lambda line: None)
        assert not cluster.worker_nodes
    (first,) = Study(tmp_path / "here", asked).done
    found = Study(tmp_path / "nodes", asked)
    assert found.spent >= 4000
    again = next(one for one in found.done if one.params == first.params)
    told = again.intermediate_values  # all of them, unless it was begun again when there was enough
    assert told == {steps: first.intermediate_values[steps] for steps in told}
    assert told
