"""Where there is no cluster to join, a sentence says so."""

import socket

import pytest

from drillrig_env.command_line import Failed
from drillrig_env.engine import engine_at

pytest.importorskip("ray")
pytestmark = pytest.mark.slow


def test_this_machine_is_part_of_none(monkeypatch):
    """Ray looks for a cluster by an address, by a file, and among the processes of this machine."""
    services = pytest.importorskip("ray._private.services")
    monkeypatch.delenv("RAY_ADDRESS", raising=False)
    monkeypatch.setattr(services, "find_gcs_addresses", set)
    monkeypatch.setattr(services, "find_bootstrap_address", lambda *_: None)
    with pytest.raises(Failed, match="--on auto: there is no cluster that this machine is part of"):
        engine_at("auto").__enter__()


def test_nobody_answers_at_an_address():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"ray://127.0.0.1:{free.getsockname()[1]}"
    with pytest.raises(Failed, match=f"--on {address}: no answer"):
        engine_at(address).__enter__()
