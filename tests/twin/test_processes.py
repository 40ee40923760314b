"""Both sides as processes of their own: killed, stopped, interrupted, on a full disk, without what is not needed."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from drillrig_env.deploy import read_log, replay_log
from tests.twin.serving import serving, soon

pytest.importorskip("onnxruntime")

COMMAND = [sys.executable, "-m", "drillrig_env.cli"]
ROOM = 20_000  # bytes that a full disk still takes: a log can be begun, and holds some of the steps


@contextmanager
def started(*words, **settings):
    """A command in a process of its own, whose lines can be waited for."""
    process = subprocess.Popen(
        [*COMMAND, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, bufsize=1, **settings
    )
    late = threading.Timer(90.0, process.kill)  # whoever waits for a line of it is let go
    late.start()
    try:
        yield process
    finally:
        late.cancel()
        process.kill()
        process.wait()
        process.stdout.close()


def line_with(process, pattern):
    """The next line that has a pattern."""
    for line in process.stdout:
        if re.search(pattern, line):
            return line
    raise AssertionError(f"{pattern} did not come")


@contextmanager
def twin(*words):
    with started("twin", "--port", "0", *words) as process:
        address = line_with(process, "listening at").split()[2].rstrip(";")
        yield process, address


@pytest.mark.slow
def test_a_controller_that_is_killed_leaves_the_rig_to_its_watchdog(tmp_path):
    log = tmp_path / "run.csv"
    with twin() as (rig, address):
        with started("run", "lqg", "--connect", address, "--log", str(log)) as controller:
            line_with(rig, "armed: armed")
            time.sleep(2.0)
            controller.kill()
        assert "no command for" in line_with(rig, "tripped: watchdog")
        found = replay_log(log)
        assert found.steps > 5
        assert found.differing == 0
        with started("run", "lqg", "--connect", address, "--duration", "1") as other:
            line_with(rig, "armed: armed")
            line_with(rig, "released")
            assert other.wait(10.0) == 0


@pytest.mark.slow
def test_a_rig_that_is_killed_ends_the_run_and_the_log_is_whole(tmp_path):
    log = tmp_path / "run.csv"
    with twin() as (rig, address), started("run", "lqg", "--connect", address, "--log", str(log)) as controller:
        line_with(rig, "armed: armed")
        time.sleep(2.0)
        rig.kill()
        assert controller.wait(10.0) == 1
        assert line_with(controller, r"error: .*(has ended the connection|is broken)")
    assert replay_log(log).differing == 0


@pytest.mark.slow
def test_a_rig_that_is_silent_for_a_while_is_survived(tmp_path):
    log = tmp_path / "run.csv"
    with twin() as (rig, address), started("run", "lqg", "--connect", address, "--log", str(log)) as controller:
        line_with(rig, "armed: armed")
        time.sleep(1.0)
        rig.send_signal(signal.SIGSTOP)
        assert "stale" in line_with(controller, "hold: fault")
        line_with(controller, "fallback: fault")
        rig.send_signal(signal.SIGCONT)
        line_with(controller, "normal: sound")
        controller.send_signal(signal.SIGINT)
        assert controller.wait(20.0) == 130


@pytest.mark.slow
def test_a_controller_that_stands_still_is_told_that_it_has_lost_the_rig():
    with twin() as (rig, address), started("run", "lqg", "--connect", address) as controller:
        line_with(rig, "armed: armed")
        time.sleep(1.0)
        controller.send_signal(signal.SIGSTOP)
        line_with(rig, "tripped: watchdog")
        controller.send_signal(signal.SIGCONT)
        assert controller.wait(10.0) == 1
        assert line_with(controller, "the watchdog of .* has taken over")


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_the_first_interrupt_stops_the_rig_and_the_second_ends_at_once(number, code, tmp_path):
    log = tmp_path / "run.csv"
    with twin("--speed-target", "1.5") as (rig, address):
        with started("run", "constant", "--connect", address, "--log", str(log)) as controller:
            line_with(rig, "armed: armed")
            time.sleep(1.0)
            controller.send_signal(number)
            line_with(controller, "stopped: stopped: at 0 rad/s")
            assert controller.wait(10.0) == code
        assert "at 0 rad/s" in line_with(rig, "released")
        assert replay_log(log).differing == 0
        with started("run", "constant", "--connect", address, "--target", "1.5") as controller:
            line_with(rig, "armed: armed")
            time.sleep(1.5)
            controller.send_signal(number)
            line_with(controller, "ramp: stop")
            begin = time.monotonic()
            controller.send_signal(number)
            assert controller.wait(5.0) == code
            assert time.monotonic() - begin < 3.0
        assert "no command for" in line_with(rig, "tripped: watchdog")
        rig.send_signal(number)
        assert rig.wait(10.0) == code


def test_on_a_full_disk_the_rig_is_controlled_on(tmp_path):
    resource = pytest.importorskip("resource")
    log = tmp_path / "run.csv"
    with serving() as served:
        words = [*COMMAND, "run", "constant", "--connect", served.address, "--duration", "20", "--log", str(log)]
        done = subprocess.run(
            words,
            capture_output=True,
            text=True,
            check=False,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (ROOM, ROOM)),
        )
        assert served.station.taken >= 198
    assert done.returncode == 1
    assert re.search("log: .* cannot be written: .*; it ends here, the rig is controlled on", done.stdout)
    assert "normal at" in done.stdout
    assert "Traceback" not in done.stderr
    assert ROOM - 1000 < log.stat().st_size <= ROOM
    found = replay_log(log)
    assert found.differing == 0
    assert 10 < found.steps < 200


def test_a_disk_that_is_full_from_the_start_turns_nothing():
    if not Path("/dev/full").exists():
        pytest.skip("this system has no /dev/full")
    with serving() as served:
        words = [*COMMAND, "run", "constant", "--connect", served.address, "--duration", "1", "--log", "/dev/full"]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        assert served.station.taken == 0
        assert soon(lambda: served.station.state == "idle")  # given back
    assert done.returncode == 1
    assert done.stderr.startswith("error: ")
    assert "no space left on device" in done.stderr


def test_it_runs_where_only_what_is_needed_can_be_imported(tmp_path):
    program = """
import sys
for name in ("torch", "stable_baselines3", "numba", "llvmlite", "scipy", "onnx", "pandas", "matplotlib", "asyncua"):
    sys.modules[name] = None  # any import of it fails
from drillrig_env.cli import main
sys.exit(main(sys.argv[1:]))
"""
    log = tmp_path / "run.csv"
    with serving() as served:
        words = ["run", "lqg", "--connect", served.address, "--duration", "2", "--log", str(log)]
        done = subprocess.run([sys.executable, "-c", program, *words], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    assert len(list(read_log(log)[1])) == 20
    words = ["run", "lqg", "--connect", "opc.tcp://127.0.0.1:4840"]
    done = subprocess.run([sys.executable, "-c", program, *words], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == "error: OPC UA needs asyncua; in a clone of DrillRig: pip install -e '.[opcua]'\n"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--host", "0.0.0.0"], "--host 0.0.0.0 is not allowed without --token-file"),
        (["--wait", "--opcua", "4840"], "--wait is not allowed with --opcua"),
        (["--port", "99999"], "'99999' is not allowed; allowed: whole, >= 0 and <= 65535"),
        (["--fault", "curent:frozen:1:2"], "unknown channel 'curent'; did you mean current?"),
        (["--fault", "current:frozen"], "allowed: channel:kind:from:to"),
        (["--speed-target", "50"], "speed_target = 50.0 rad/s is not allowed"),
        (["--loss", "1.5"], "allowed: >= 0 and <= 1"),
        (["--token-file", os.devnull, "--host", "0.0.0.0"], "length of the first line = 0 characters"),
    ],
)
def test_a_twin_that_cannot_be_is_named(words, told, capsys):
    from drillrig_env.cli import main

    with pytest.raises(SystemExit) as ended:
        main(["twin", *words])
    assert ended.value.code == 2
    assert told in capsys.readouterr().err


def test_a_port_that_is_taken_is_named(capsys):
    from drillrig_env.cli import main

    with serving() as served:
        assert main(["twin", "--port", served.address.split(":")[1]]) == 1
    assert "address already in use" in capsys.readouterr().err.lower()
