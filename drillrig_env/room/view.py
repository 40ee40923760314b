"""What a client is told of its room in words and plain numbers: what there is to choose from, how all controls are."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

from drillrig_env.course import COLUMNS
from drillrig_env.env.sensors import LONGEST_DELAY, SENSORS
from drillrig_env.env.task import Task
from drillrig_env.rig import Rig
from drillrig_env.room import protocol
from drillrig_env.room.frames import VERDICT_VALUES
from drillrig_env.room.lane import SIGNAL_UNITS, SIGNALS, STEP_VALUES
from drillrig_env.room.stock import Stock
from drillrig_env.room.stories import STORIES

if TYPE_CHECKING:
    from drillrig_env.room.session import Session

LARGEST_FORCE = 40.0
"""End of the slider and of the map on the chapter's rig, N."""

_SLIDERS = {
    "speed_target": (0.2, 6.0, 0.02),
    "normal_force": (0.0, LARGEST_FORCE, 0.1),
    "mu_s": (0.05, 1.0, 0.005),
    "mu_k": (0.0, 0.9, 0.005),
    "v_b": (0.1, 4.0, 0.02),
}
"""Ends and step of each slider on the chapter's rig; fields take whatever the rig allows."""


def welcome(stock: Stock, begin: dict[str, Any]) -> str:
    """The first text that a client gets: names, units and stories, and what the command line asked for."""
    stories = [
        {
            "name": name,
            "title": story.title,
            "parts": [{"heading": part.heading, "text": part.text} for part in story.parts],
        }
        for name, story in STORIES.items()
    ]
    return protocol.write(
        "welcome",
        version=protocol.VERSION,
        rigs=list(stock.rigs),
        policies=list(stock.policies),
        sensors=list(SENSORS),
        longest_delay=LONGEST_DELAY,
        stories=stories,
        given=list(COLUMNS),
        signals=dict(zip(SIGNALS, SIGNAL_UNITS, strict=True)),
        step_values=list(STEP_VALUES),
        verdict_values=list(VERDICT_VALUES),
        begin=begin,
    )


def state(session: Session) -> dict[str, Any]:
    """How all controls are."""
    lanes = session.lanes
    task = lanes.lanes[0].task
    setting = {**lanes.setting.as_dict(), **lanes.given.values}
    if lanes.recorded is not None:
        policies = [lane.policy for lane in lanes.recorded.lanes.values()]
    else:
        policies = [lanes.setting.a, lanes.setting.b]
    return {
        "run": session.run_number,
        "setting": setting,
        "paused": session.paused,
        "times": session.times,
        "step": lanes.step_number,
        "period": lanes.period,
        "at_end": lanes.at_end,
        "replay": lanes.recorded is not None,
        "ramps": lanes.given.ramps,
        "story": None if session.story is None else {"name": session.story[0], "part": session.story[1]},
        "sliders": sliders(task.rig),
        "largest_reference": task.largest_reference,
        "time_scale": task.scales.time,
        "largest_force": LARGEST_FORCE * task.scales.force,
        "law": str(task.scenario.friction.law),
        "lanes": [
            {
                "name": lane.name,
                "policy": policy,
                "hand": lane.hand,
                "reference": lane.speed_reference,
                "channels": [[channel.name, channel.unit] for channel in lane.task.sensors.channels],
                "own_drive": lane.task.drive is not None,
            }
            for lane, policy in zip(lanes.lanes, policies, strict=True)
        ],
    }


@lru_cache(maxsize=32)
def sliders(rig: Rig) -> dict[str, tuple[float, float, float]]:
    """Lowest value, highest value and step of the sliders on a rig."""
    scales = Task.for_rig(rig).scales
    factors = {"speed_target": scales.speed, "normal_force": scales.force, "v_b": 1.0 / scales.speed}
    found = {}
    for name, ends in _SLIDERS.items():
        low, high, step = (float(f"{end * factors.get(name, 1.0):.2g}") for end in ends)
        found[name] = (low, high, step)
    return found
