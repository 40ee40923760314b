"""A policy controls the twin over its line: as well as without one, whatever instruments and messages do."""

import json
import socket
import threading
import time as system
from contextlib import closing, suppress

import pytest

from drillrig_env.calibrate.records import read_record
from drillrig_env.cli import main
from drillrig_env.deploy import Limits, Supervisor, read_log, replay_log, run_loop
from drillrig_env.deploy.connection import compare, connect
from drillrig_env.seeds import VALIDATION_SEEDS
from drillrig_env.twin.channel import Wire
from drillrig_env.twin.dry_run import DryRig, Instant
from drillrig_env.twin.faults import Fault
from drillrig_env.twin.rig import SimulatedRig
from tests.twin.serving import serving, soon

pytest.importorskip("onnxruntime")

STICKING = {"start": "stick_slip", "speed_target": 3.0, "normal_force": 20.0, "load_steps": []}


def controlled(policy="lqg", steps=600, log=None, limits=None, **settings):
    """What became of a rig in stick-slip over the line: the station, and the supervisor."""
    settings = {"rig": SimulatedRig(VALIDATION_SEEDS.start, options=STICKING), **settings}
    with serving(**settings) as served, closing(connect(served.address)) as rig:
        supervisor = Supervisor(policy, limits)
        assert compare(supervisor, rig) == []
        run_loop(supervisor, rig, reference=rig.arm, target=rig.target, steps=steps, log=log, clock=rig.clock,
                 sleep=rig.sleep)  # fmt: skip
        return served.station, supervisor


def ended(words):
    """The exit code of a command."""
    try:
        return main(words)
    except SystemExit as end:
        return end.code


@pytest.mark.parametrize(("policy", "sensors"), [("lqg", "surface"), ("ppo", "state")])
def test_it_calms_the_rig_as_without_a_line(policy, sensors):
    noiseless = Limits(frozen=10_000)  # the state's instruments are exact, and stand still with the rig
    limits = noiseless if sensors == "state" else None
    station, supervisor = controlled(
        policy, rig=SimulatedRig(VALIDATION_SEEDS.start, sensors, options=STICKING), limits=limits
    )
    assert station.rig.is_mitigated
    assert [event.kind for event in supervisor.events.kept] == ["start"]
    assert station.taken >= 599  # the last one may be underway
    dry, time = DryRig(0, sensors=sensors, options=STICKING), Instant()
    for _ in range(5):
        dry.advance()  # the loop begins with the first measurements
    alone = Supervisor(policy, limits)
    run_loop(alone, dry, reference=dry.reference, target=dry.target, steps=600, clock=time, sleep=time.sleep)
    assert dry.is_mitigated
    assert supervisor.reference == pytest.approx(alone.reference, abs=0.02)


def test_the_log_replays_and_is_a_record(tmp_path):
    log = tmp_path / "run.csv"
    station, _ = controlled(steps=80, log=log, wire=Wire(loss=0.1, jitter=0.05), periods=10, seed=3)
    assert replay_log(log).differing == 0
    assert replay_log(log).steps == 80
    rows = list(read_log(log)[1])
    assert any(row.ages["current"] > 0.05 for row in rows)
    assert rows[-1].command == pytest.approx(station.rig.reference, abs=0.4)
    assert set(read_record(log).signals) >= {"top_speed", "current", "voltage"}


@pytest.mark.slow
def test_the_same_seed_loses_the_same_messages(tmp_path):
    logs = [tmp_path / f"{k}.csv" for k in range(3)]
    for log, seed in zip(logs, (1, 1, 2), strict=True):
        controlled("constant", steps=30, log=log, wire=Wire(loss=0.2, jitter=0.05), periods=50, seed=seed)
    one, again, other = (log.read_text() for log in logs)
    assert one == again != other


@pytest.mark.parametrize("kind", ["missing", "frozen", "wild", "slow"])
def test_a_failing_instrument_is_survived(kind):
    """Held, then taken over by the simple law, and given back: the drive always has a sensible reference."""
    faults = [Fault("current", kind, 2.0, 6.0)]
    station, supervisor = controlled(steps=100, faults=faults, limits=Limits(fallback="z_torque"))
    told = {event.state for event in supervisor.events.kept}
    assert {"hold", "fallback", "normal"} <= told
    assert supervisor.state.value == "normal"
    assert station.taken >= 99
    assert 0.5 < station.rig.reference < 6.0


def test_a_lie_that_can_be_believed_meets_the_limits():
    """Of a sensor that drifts nobody knows; range, rate and overload still hold."""
    faults = [Fault("current", "drifting", 1.0, 60.0)]
    station, supervisor = controlled(steps=250, faults=faults, limits=Limits(highest_reference=3.5, current=2.0))
    assert supervisor.events.of("limit")
    assert station.rig.reference <= 3.5


def test_a_wire_that_is_dead_trips_the_watchdog():
    with pytest.raises(ConnectionError, match=r"the watchdog of .* has taken over"):
        controlled("constant", steps=100, wire=Wire(latency=0.5))


def test_shadow_mode_commands_nothing(tmp_path, capsys):
    with serving() as served:
        words = ["run", "lqg", "--connect", served.address, "--duration", "5", "--shadow"]
        assert main([*words, "--log", str(tmp_path / "shadow.csv")]) == 0
        assert served.station.state == "idle"
        assert served.station.rig.reference == served.station.rig.target
    rows = list(read_log(tmp_path / "shadow.csv")[1])
    assert len({row.told for row in rows}) == 1
    assert len({row.command for row in rows}) > 5
    assert "normal at" in capsys.readouterr().out


def test_the_command_runs_a_policy_within_limits(tmp_path, capsys):
    log = str(tmp_path / "run.csv")
    with serving(token="0123456789abcdef") as served:
        words = ["run", "constant", "--connect", served.address, "--duration", "4", "--log", log]
        assert main(words) == 1
        assert "refuses: the token is not this rig's" in capsys.readouterr().err
        (tmp_path / "token").write_text("0123456789abcdef\n")
        words += ["--token-file", str(tmp_path / "token"), "--target", "4", "--highest-reference", "2.5"]
        assert main(words) == 0
        assert soon(lambda: served.station.state == "idle")  # given back
        assert served.station.rig.reference == pytest.approx(2.5)
    told = capsys.readouterr().out
    assert "limit: the policy wants" in told
    assert "normal at 2.5 rad/s after 4 s" in told
    assert main(["replay", log]) == 0
    earlier = (tmp_path / "run.csv").read_bytes()
    assert ended(words) == 2
    assert "run.csv is there already" in capsys.readouterr().err
    assert (tmp_path / "run.csv").read_bytes() == earlier


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        (["lgq", "--connect", "127.0.0.1:1"], 2, "did you mean lqg"),
        (["lqg", "--connect", "here"], 2, "address 'here' is not allowed; allowed: HOST:PORT"),
        (["lqg", "--connect", "http://127.0.0.1:1"], 2, "127.0.0.1:5025, or opc.tcp://HOST:PORT"),
        (["lqg", "--connect", "127.0.0.1:²"], 2, "allowed: HOST:PORT"),
        (["lqg", "--connect", "127.0.0.1:1", "--log", "/nowhere/x.csv"], 1, "the log /nowhere/x.csv cannot be begun"),
        (["lqg", "--connect", "127.0.0.1:1"], 1, "there is no rig at 127.0.0.1:1: Connection refused"),
        (["lqg", "--connect", "127.0.0.1:1", "--rate", "-1"], 2, "allowed: > 0 rad/s^2"),
        (["lqg", "--connect", "127.0.0.1:1", "--lowest-reference", "20"], 2, "lowest_reference = 20.0 rad/s"),
        (["lqg", "--connect", "127.0.0.1:1", "--token-file", "/nowhere"], 2, "token: '/nowhere' is no file"),
        (["lqg"], 2, "the following arguments are required: --connect"),
    ],
)
def test_what_cannot_be_run_is_named(words, code, told, capsys):
    assert ended(["run", *words]) == code
    assert told in capsys.readouterr().err


def test_an_end_without_the_policy_is_no_success(capsys):
    with serving() as served:
        words = ["run", "constant", "--connect", served.address, "--duration", "1", "--top-speed", "1"]
        assert main(words) == 1
        assert "the time is over in the state ramp: the policy does not control the rig" in capsys.readouterr().err
        assert soon(lambda: served.station.state == "idle")


def test_a_rig_that_does_not_offer_what_the_policy_wants_is_refused(capsys):
    with serving() as served:
        assert main(["run", "ppo", "--connect", served.address]) == 1
        assert "ppo wants twist_12 (rad); the rig offers top_speed (rad/s), current (A)" in capsys.readouterr().err
        assert main(["run", "lqg", "--connect", served.address, "--target", "40", "--duration", "1"]) == 1
        assert "speed_target = 40.0 rad/s is not allowed" in capsys.readouterr().err
        assert soon(lambda: served.station.state == "idle")  # given back: nothing was wrong with the rig


def test_another_rig_or_drive_is_told_of_before_anything_turns(capsys):
    with serving(SimulatedRig(rig={"k_p": 5.0, "J_1": 0.05}, delay=2)) as served:
        words = ["run", "constant", "--connect", served.address, "--duration", "1"]
        assert main(words) == 1
        assert "control period of the rig = " in capsys.readouterr().err
    with serving(SimulatedRig(rig={"k_p": 5.0}, delay=2)) as served:
        assert main([*words[:3], served.address, *words[4:]]) == 0
        told = capsys.readouterr().out
        assert "mind: drive: k_p is 5, the policy is for 3" in told
        assert "mind: instruments are 2 control steps late, the policy is for 1 to 1" in told


@pytest.mark.parametrize(
    "said",
    [
        b"HTTP/1.1 400 Bad Request\r\n",
        b'{"rig": 1}\n',
        b'{"rig": 1, "time": 1' + b"0" * 400 + b"}\n",
        b"x" * 100_000,
        b"",
        b'{"refused": "no"}\n',
    ],
)
def test_what_is_no_rig_is_named(said):
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            client, _ = server.accept()
            with client:
                client.recv(1000)
                client.sendall(said)

        thread = threading.Thread(target=serve)
        thread.start()
        with pytest.raises(ConnectionError, match=r"no rig of this protocol|refuses: no|has ended|is broken"):
            connect(f"127.0.0.1:{server.getsockname()[1]}")
        thread.join()


def test_a_rig_of_ones_own_needs_no_more_than_the_page_says():
    """A program that says only what docs/line_protocol.md asks for, in real time."""
    heard = []

    def serve(server):
        client, _ = server.accept()
        with client, client.makefile("rb") as lines:
            heard.append(json.loads(lines.readline()))
            units = {"top_speed": "rad/s", "current": "A", "voltage": "V", "string_torque": "N m"}
            numbers = {"version": 1, "period": 0.1, "speed": 1.0, "time": 0.0, "reference": 2.0, "target": 2.5}
            client.sendall(json.dumps({"rig": "mine", "channels": units, **numbers}).encode() + b"\n")
            reader = threading.Thread(target=lambda: heard.extend(json.loads(line) for line in lines))
            reader.start()
            for k in range(1, 13):
                system.sleep(0.1)
                if {"arm": True} in heard and not any("armed" in said for said in told):
                    told.append({"armed": 2.0, "time": 0.1 * k - 0.05})
                told.append({"time": 0.1 * k, "values": dict.fromkeys(units, 0.5 + 0.01 * k), "reference": 2.0,
                             "state": "armed"})  # fmt: skip
                with suppress(ConnectionError):  # the client has gone in the end
                    client.sendall(b"".join(json.dumps(said).encode() + b"\n" for said in told[len(sent) :]))
                sent.extend(told[len(sent) :])
            reader.join(5.0)

    told, sent = [], []
    with socket.create_server(("127.0.0.1", 0)) as server:
        thread = threading.Thread(target=serve, args=(server,))
        thread.start()
        assert main(["run", "constant", "--connect", f"127.0.0.1:{server.getsockname()[1]}", "--duration", "0.5"]) == 0
        thread.join(5.0)
    assert heard[0]["hello"]
    assert [next(iter(said)) for said in heard[1:]] == ["arm", *["command"] * 5, "release"]
    assert [said["command"] for said in heard[2:-1]] == pytest.approx([2.2, 2.4, 2.5, 2.5, 2.5])
