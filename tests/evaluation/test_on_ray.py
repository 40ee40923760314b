"""Evaluations on Ray: the digests of one process from workers and nodes, also where these are killed in the midst."""

import os
import re

import pytest

from drillrig_env.cli import main
from drillrig_env.engine import Local, engine_at
from drillrig_env.engine.on_ray import OnRay
from drillrig_env.evaluation.evaluate import evaluate
from drillrig_env.evaluation.store import CSV, HISTORIES
from tests.engine.nodes import two_nodes

pytest.importorskip("ray.cluster_utils")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name == "nt", reason="signals")]

RIGS = 2200
POLICIES = ("constant", "ppo")


class KillsOnce:
    """A policy that kills the process which is first to play a piece from the second on."""

    def __init__(self, mark):
        self.mark, self.held = mark, 0

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        if len(observation) < 1000 and state is None and not self.mark.exists():
            self.mark.touch()
            os.kill(os.getpid(), 9)
        return 0.01 * observation[:, :1].clip(-1.0, 1.0), (observation[:, 0],)


def content(folder, engine, policies=POLICIES, progress=None):
    results = evaluate(policies, rigs=RIGS, folder=folder, engine=engine, progress=progress)
    return results.rows, (folder / HISTORIES).read_bytes()


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    return content(tmp_path_factory.mktemp("alone"), None)


@pytest.mark.parametrize("workers", [1, 2, 4])
def test_workers_of_ray_give_the_digests_of_one_process(workers, alone, tmp_path):
    with engine_at("ray", workers) as engine:
        assert content(tmp_path, engine) == alone


def test_processes_give_the_digests_of_one(alone, tmp_path):
    with Local(2) as engine:
        assert content(tmp_path, engine) == alone


def test_a_worker_that_is_killed_changes_nothing(tmp_path):
    mark = tmp_path / "mark"
    mark.touch()
    whole = content(tmp_path / "alone", None, [KillsOnce(mark)])
    mark.unlink()
    with engine_at("ray", 2) as engine:
        assert content(tmp_path / "ray", engine, [KillsOnce(mark)]) == whole
    assert mark.exists()


def test_two_nodes_of_which_one_is_killed_give_the_digests_of_one_process(alone, tmp_path):
    with two_nodes() as (cluster, kill_when), OnRay(cluster.address) as engine:
        kill_when(lambda: bool(list((tmp_path / "pieces").rglob("*.npz"))))
        assert content(tmp_path, engine) == alone


def test_all_that_take_part_have_on_ray_the_digests_of_one_process(tmp_path):
    """On few rigs, a piece each: policies are what travels here."""
    for name, there in (("alone", ()), ("ray", ("--on", "ray", "--jobs", "2"))):
        words = ["--suite", "default", "--rigs", "40", "--no-pictures", "--output", str(tmp_path / name), *there]
        assert main(["evaluate", *words]) == 0
    alone, found = ((tmp_path / name / CSV).read_bytes() for name in ("alone", "ray"))
    assert len(set(re.findall(rb"^default,([^,]+)", alone, re.MULTILINE))) >= 9
    assert found == alone
    assert (tmp_path / "ray" / HISTORIES).read_bytes() == (tmp_path / "alone" / HISTORIES).read_bytes()
