"""The same rig behind OPC UA."""

import time
from contextlib import closing

import pytest

from drillrig_env.deploy import Limits, Supervisor, opcua_nodes, read_log, replay_log, run_loop
from drillrig_env.deploy.connection import compare, connect
from drillrig_env.twin.faults import Fault
from drillrig_env.twin.rig import SimulatedRig
from tests.twin.serving import free_port, serving

asyncua = pytest.importorskip("asyncua")
pytest.importorskip("onnxruntime")

pytestmark = pytest.mark.slow  # a server of OPC UA takes seconds to begin


def served_over_opcua(rig=None, **settings):
    return serving(rig, opcua=True, waits=False, speed=5.0, **settings)


def test_a_policy_controls_it_and_a_replay_agrees(tmp_path):
    log = tmp_path / "run.csv"
    faults = [Fault("current", "missing", 12.0, 14.0), Fault("voltage", "slow", 12.0, 14.0)]
    with served_over_opcua(faults=faults, periods=50) as served, closing(connect(served.address)) as rig:
        supervisor = Supervisor("z_torque", Limits(sound_time=0.3))
        assert compare(supervisor, rig) == []
        reference = served.station.rig.reference
        run_loop(supervisor, rig, reference=rig.arm, target=rig.target, steps=150, log=log, clock=rig.clock,
                 sleep=rig.sleep)  # fmt: skip
        assert served.station.rig.reference != reference
        rig.release()
        assert served.station.state == "idle"
    reasons = " ".join(event.reason for event in supervisor.events.of("fault"))
    assert "current missing" in reasons
    assert "voltage stale" in reasons
    assert replay_log(log).differing == 0
    rows = list(read_log(log)[1])
    assert rows[5].measured["top_speed"] == pytest.approx(2.0, abs=0.5)


def test_what_it_measures_is_what_the_line_tells():
    exact = SimulatedRig(sensors="state", noise=0.0)
    with served_over_opcua(exact) as served, closing(connect(served.address)) as rig:
        assert rig.channels == served.station.rig.channels
        measured = rig.measure()
        assert set(measured) == set(rig.channels)
        assert len(measured["bit_speed"]) == 5
        assert max(rig.ages().values()) < 1.0
        assert rig.drive_reference() == rig.first_reference() == rig.target


def test_one_client_has_the_rig_and_a_key_that_is_old_does_nothing():
    with (
        served_over_opcua() as served,
        closing(connect(served.address)) as one,
        closing(connect(served.address)) as two,
    ):
        one.arm()
        with pytest.raises(ConnectionError, match="another client has the rig"):
            two.arm()
        with pytest.raises(ConnectionError, match="command without the rig"):
            two.command(2.0)
        end = time.monotonic() + 20.0
        while served.station.state != "tripped" and time.monotonic() < end:
            time.sleep(0.05)
        time.sleep(0.1)
        with pytest.raises(ConnectionError, match=r"watchdog of .* has taken over"):
            one.measure()
        two.arm()
        with pytest.raises(ConnectionError, match="command without the rig"):
            one.command(2.0)


def test_with_a_token_nobody_gets_in_without_it():
    with served_over_opcua(token="t" * 20) as served:
        for token in ("", "wrong"):
            with pytest.raises(ConnectionError, match="refuses"):
                connect(served.address, token)
        with closing(connect(served.address, "t" * 20)) as rig:
            assert rig.target == served.station.rig.target


def test_where_there_is_no_rig_that_is_said():
    with pytest.raises(ConnectionError, match=r"there is no rig at .*: Connection refused"):
        connect(f"opc.tcp://127.0.0.1:{free_port()}")
    with serving() as served, pytest.raises(ConnectionError, match="there is no rig at"):
        connect(f"opc.tcp://{served.address}")


def test_its_nodes_can_be_written_by_nobody():
    with served_over_opcua() as served, closing(connect(served.address)) as rig:
        node = rig._node(opcua_nodes.REFERENCE)
        with pytest.raises(asyncua.ua.UaStatusCodeError):
            node.write_value(9.0)
