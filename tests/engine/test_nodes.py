"""Two machines, as two nodes of a cluster on this one: the second is killed in the midst of the work."""

import os
import threading
import time
from pathlib import Path

import pytest

from drillrig_env.engine.on_ray import OnRay

cluster_utils = pytest.importorskip("ray.cluster_utils")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name == "nt", reason="signals")]


def slow_square(piece):
    number, folder = piece
    Path(folder, f"{number}.begun").touch()
    time.sleep(0.3)
    return number**2


@pytest.fixture
def cluster():
    """Two nodes of one core each; the second is the last of its list of workers."""
    settings = {"num_cpus": 1, "object_store_memory": 100_000_000}
    found = cluster_utils.Cluster(initialize_head=True, head_node_args={**settings, "include_dashboard": False})
    found.add_node(**settings)
    yield found
    found.shutdown()


def test_a_node_that_is_killed_loses_nothing(cluster, tmp_path):
    second = next(iter(cluster.worker_nodes))

    def kill():
        while len(list(tmp_path.glob("*.begun"))) < 5:
            time.sleep(0.02)
        cluster.remove_node(second, allow_graceful=False)

    with OnRay(cluster.address) as engine:
        threading.Thread(target=kill, daemon=True).start()
        assert engine.map(slow_square, [(number, tmp_path) for number in range(24)]) == [n**2 for n in range(24)]
        assert not cluster.worker_nodes
