"""Two machines, as two nodes of a cluster on this one, of which the second can be killed in the midst of work."""

import threading
import time
from contextlib import contextmanager


@contextmanager
def two_nodes():
    """A cluster of two nodes of one core each, and a function that kills the second as soon as a condition holds."""
    from ray.cluster_utils import Cluster

    settings = {"num_cpus": 1, "object_store_memory": 100_000_000}
    cluster = Cluster(initialize_head=True, head_node_args={**settings, "include_dashboard": False})
    second = cluster.add_node(**settings)

    def kill_when(condition):
        def watch():
            while not condition():
                time.sleep(0.02)
            cluster.remove_node(second, allow_graceful=False)

        threading.Thread(target=watch, daemon=True).start()

    try:
        yield cluster, kill_when
    finally:
        cluster.shutdown()
