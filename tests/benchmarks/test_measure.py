"""What the benchmarks share: what was measured is kept, whatever ends the measuring; impossible numbers are refused."""

import importlib
import json
import os
import signal
import subprocess
import sys

import pytest

from benchmarks.measure import kept, write_json
from benchmarks.peers import PEERS
from benchmarks.peers.peer import asked_for
from drillrig_env.command_line import deaf_to_interrupt

NAMES = ("solvers", "batches", "environments", "stability", "startup", "training")


def test_what_was_measured_is_reported_at_the_end_and_when_stopped(tmp_path):
    told = []
    with kept(tmp_path / "a.json", lambda: told.append("end")):
        pass
    with pytest.raises(KeyboardInterrupt) as stop, kept(tmp_path / "a.json", lambda: told.append("stop")):
        raise KeyboardInterrupt
    assert told == ["end", "stop"]
    assert stop.value.__notes__ == ["what was measured is kept"]


def test_a_file_that_cannot_be_written_is_found_out_before_anything_is_measured(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match="cannot be written"), kept(tmp_path / "file" / "a.json", pytest.fail):
        pytest.fail("measured")


def test_figures_that_are_not_finite_are_null(tmp_path):
    write_json(tmp_path / "new" / "a.json", {"error": float("nan")}, announce=False)
    assert json.loads((tmp_path / "new" / "a.json").read_text())["results"] == {"error": None}


@pytest.mark.skipif(os.name == "nt", reason="Windows has no signals between processes")
def test_a_process_that_is_started_hears_no_interrupt_and_this_one_does_again():
    raised = [sys.executable, "-c", "import signal; signal.raise_signal(signal.SIGINT)"]
    with deaf_to_interrupt():
        assert subprocess.run(raised, stderr=subprocess.DEVNULL).returncode == 0
    assert subprocess.run(raised, stderr=subprocess.DEVNULL).returncode == -signal.SIGINT


def test_solvers_are_asked_for_by_part_of_their_name():
    assert [peer.name for peer in asked_for(PEERS, ["radau"])] == ["SciPy solve_ivp Radau"]
    assert len(asked_for(PEERS, [])) == sum(peer.package.found for peer in PEERS)
    with pytest.raises(ValueError, match="--only: no solver has 'nosuch' in its name; allowed: DrillRig"):
        asked_for(PEERS, ["radau", "nosuch"])


def test_a_solver_that_is_not_installed_is_refused_with_what_to_do():
    absent = [peer for peer in PEERS if not peer.package.found]
    if not absent:
        pytest.skip("all solvers are installed")
    with pytest.raises(ValueError, match=r"is not installed|pip install"):
        asked_for(PEERS, [absent[0].name])


@pytest.mark.parametrize("value", ["0", "-1", "1.5"])
@pytest.mark.parametrize("name", NAMES)
def test_numbers_below_one_are_refused_before_anything_is_measured(name, value, tmp_path, monkeypatch, capsys):
    file = tmp_path / "figures.json"
    monkeypatch.setattr(sys, "argv", [name, "--repeats", value, "--json", str(file)])
    with pytest.raises(SystemExit) as end:
        importlib.import_module(f"benchmarks.{name}").main()
    assert end.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith(f"python -m benchmarks.{name}: error: argument --repeats: '{value}' is not allowed")
    assert not file.exists()
