"""A map of the plane, point by point, by two machines of which one is killed in the midst."""

import os

import numpy as np
import pytest

from drillrig_env import Friction, Rig
from drillrig_env.engine.on_ray import OnRay
from drillrig_env.stability import vibration_map
from drillrig_env.stability.vibration_map import simulated_map
from tests.engine.nodes import two_nodes

pytest.importorskip("ray.cluster_utils")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name == "nt", reason="signals")]


def test_it_is_the_map_of_one_process(tmp_path, monkeypatch):
    monkeypatch.setattr(vibration_map, "_CHUNK", 400)
    speeds, forces = np.linspace(0.8, 6.0, 100), np.linspace(4.0, 40.0, 100)
    whole = simulated_map(Rig(), Friction(), speeds, forces, duration=45.0)
    with two_nodes() as (cluster, kill_when), OnRay(cluster.address) as engine:
        kill_when(lambda: len(list(tmp_path.glob("piece_*.npz"))) >= 3)
        found = simulated_map(Rig(), Friction(), speeds, forces, duration=45.0, engine=engine, folder=tmp_path)
        assert not cluster.worker_nodes
    np.testing.assert_array_equal(found.region, whole.region)
