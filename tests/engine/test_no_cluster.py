"""Where there is no cluster to join, a sentence says so."""

import signal
import socket
import subprocess
import sys

import pytest

from drillrig_env.command_line import Failed
from drillrig_env.engine import engine_at

pytest.importorskip("ray")
pytestmark = pytest.mark.slow


def test_this_machine_is_part_of_none(monkeypatch):
    def init(**_settings):
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        raise ConnectionError("Could not find any running Ray instance.\nMore lines")

    earlier = signal.getsignal(signal.SIGTERM)
    monkeypatch.setattr("ray.init", init)
    with pytest.raises(Failed, match=r"--on auto: there is no cluster .* own instance \(Could not .* Ray instance\.\)"):
        engine_at("auto").__enter__()
    engine = engine_at("ray", 1)
    with pytest.raises(Failed, match="--on ray: Ray does not start"):
        engine.__enter__()
    assert engine._folder is None  # nothing is left behind
    assert signal.getsignal(signal.SIGTERM) is earlier


def test_nobody_listens_at_an_address(capsys):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"ray://127.0.0.1:{free.getsockname()[1]}"
    with pytest.raises(Failed, match=rf"--on {address}: no answer \(connection refused\)"):
        engine_at(address).__enter__()
    assert capsys.readouterr().err == f"--on {address}: asking, for up to 40 s\n"


def test_what_listens_at_an_address_is_no_ray():
    """In a process of its own: Ray's client leaves threads behind, beside which Ray cannot always start again."""
    program = """
import sys
import ray.util.client.worker as client
from ray._private.client_mode_hook import client_mode_should_convert
from drillrig_env.command_line import Failed
from drillrig_env.engine import engine_at

client.INITIAL_TIMEOUT_SEC = client.MAX_TIMEOUT_SEC = 1
try:
    engine_at(sys.argv[1]).__enter__()
except Failed as error:
    print(error)
print(client_mode_should_convert())
"""
    with socket.create_server(("127.0.0.1", 0)) as mute:
        address = f"ray://127.0.0.1:{mute.getsockname()[1]}"
        words = [sys.executable, "-c", program, address]
        done = subprocess.run(words, capture_output=True, text=True, check=True, timeout=120)
    said, converts = done.stdout.splitlines()
    assert said.startswith(f"--on {address}: no answer")
    assert converts == "False"  # what is Ray's is no client's afterwards
    assert done.stderr == f"--on {address}: asking, for up to 40 s\n"
