"""Two machines of which the second is killed in the midst of the work."""

import os
import time
from pathlib import Path

import pytest

from drillrig_env.engine.on_ray import OnRay
from tests.engine.nodes import two_nodes

pytest.importorskip("ray.cluster_utils")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name == "nt", reason="signals")]


def slow_square(piece):
    number, folder = piece
    Path(folder, f"{number}.begun").touch()
    time.sleep(0.3)
    return number**2


def test_a_node_that_is_killed_loses_nothing(tmp_path):
    with two_nodes() as (cluster, kill_when), OnRay(cluster.address) as engine:
        kill_when(lambda: len(list(tmp_path.glob("*.begun"))) >= 5)
        assert engine.map(slow_square, [(number, tmp_path) for number in range(24)]) == [n**2 for n in range(24)]
        assert not cluster.worker_nodes
