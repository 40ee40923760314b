"""The solvers that the project is measured against, one file for each library; importing this needs none of them."""

from __future__ import annotations

from benchmarks.peers import (
    diffrax_solvers,
    heyoka_taylor,
    numbalsoda_solvers,
    project,
    scipy_solvers,
    sundae,
    torchdiffeq_solvers,
)
from benchmarks.peers.peer import BatchPeer, Peer

PEERS: tuple[Peer, ...] = (
    *project.PEERS,
    *scipy_solvers.PEERS,
    *numbalsoda_solvers.PEERS,
    *sundae.PEERS,
    *heyoka_taylor.PEERS,
    *diffrax_solvers.PEERS,
)
"""For one rig, the project first."""

BATCH_PEERS: tuple[BatchPeer, ...] = (
    *project.BATCH_PEERS,
    *numbalsoda_solvers.BATCH_PEERS,
    *diffrax_solvers.BATCH_PEERS,
    *torchdiffeq_solvers.BATCH_PEERS,
)
"""For many rigs, the project first."""
