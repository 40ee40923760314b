"""A run that a page keeps is the environment's, and is played again where its rig is."""

import json

import pytest

pytest.importorskip("starlette", reason="needs the extra room")

from drillrig_env.env.recorded import Recorded
from drillrig_env.env.single import DrillRigEnv
from drillrig_env.rig import Rig
from drillrig_env.room.lanes import Lanes
from drillrig_env.room.setting import Setting
from drillrig_env.room.stock import Stock
from tests.room.visitor import ROOM, Page


def test_values_given_before_the_first_step_are_those_of_the_start(client):
    with client().websocket_connect(ROOM) as socket:
        page = Page(socket)
        page.say("pause", paused=True)
        page.say("restart")
        page.text("state", paused=True, step=0)
        page.say("give", values={"normal_force": 21.0})
        page.text("state", step=0)
        page.say("step")
        page.text("state", step=1)
        page.say("keep", what="run")
        run = Recorded.of(json.loads(page.text("file")["text"]))
        assert run.course.values("normal_force").tolist() == [21.0]


def test_a_run_that_is_kept_is_the_environments_and_is_played_again(client):
    with client().websocket_connect(ROOM) as socket:
        page = Page(socket, {"a": "z_torque", "sensors": "surface", "b": "ppo_surface", "seed": 4})
        page.say("pause", paused=True)
        for step in range(30):
            page.say("step")
            if step == 10:
                page.say("give", values={"normal_force": 17.5})
        page.text("state", step=30)
        page.say("keep", what="csv")
        lines = page.text("file")["text"].splitlines()
        assert lines[0].startswith("time [s],normal_force [N],mu_s,mu_k,v_b [s/rad],speed_target [rad/s],A_action")
        assert len(lines) == 31
        page.say("keep", what="run")
        kept = json.loads(page.text("file")["text"])
        run = Recorded.of(kept)
        column = lines[0].split(",").index("B_bit_speed [rad/s]")
        env = DrillRigEnv(**run.environment("B"))
        env.reset(**run.reset)
        for line, action in zip(lines[1:], run.actions("B"), strict=True):
            env.step(action)
            assert line.split(",")[column] == f"{env.core.episodes['state'][0, 2]:.10g}"
        page.say("replay", run=kept)
        assert page.text("state", replay=True)["lanes"][1]["policy"] == "ppo_surface"


def test_a_run_has_no_other_lanes_than_the_room(client, stock):
    lanes = Lanes(Setting(b="constant"), stock)
    lanes.step()
    run = lanes.as_recorded().as_json()
    for names in (["C"], ["A", "B", "C"], [str(number) for number in range(500)]):
        with client().websocket_connect(ROOM) as socket:
            page = Page(socket)
            page.say("replay", run={**run, "lanes": dict.fromkeys(names, run["lanes"]["A"])})
            assert "are not allowed; allowed: A, B" in page.text("refused", field="replay")["sentence"]


def test_a_run_of_another_rig_is_played_from_the_command_line_alone(client):
    lanes = Lanes(Setting(rig="own", b="constant"), Stock.of(Rig(J_1=0.03)))
    lanes.step()
    run = lanes.as_recorded()
    with client().websocket_connect(ROOM) as socket:
        page = Page(socket)
        page.say("replay", run=run.as_json())
        assert "its rig is none of this room's" in page.text("refused")["sentence"]
    with client(recorded=run).websocket_connect(ROOM) as socket:
        page = Page(socket)
        assert page.text("state", at_end=True)["replay"]
