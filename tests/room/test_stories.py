"""What the stories say comes true, whenever whoever tells them goes on."""

import pytest

from drillrig_env.room.lanes import Lanes
from drillrig_env.room.setting import Setting
from drillrig_env.room.stories import STORIES

WAITS = (200, 204, 208, 212, 216, 220)
"""Control steps for which a part is told: a cycle takes some 25, so that the next part begins anywhere in it."""


def told(stock, name, wait, last=450):
    """The verdicts on both lanes at the end of each part of a story that begins one run."""
    parts = STORIES[name].parts
    lanes, verdicts = Lanes(Setting(**parts[0].setting), stock), []
    for place, part in enumerate(parts):
        if part.values:
            lanes.given.set(part.values)
        for ramp in part.ramps:
            lanes.given.ramp(*ramp, lanes.step_number)
        for _ in range(last if place == len(parts) - 1 else wait):
            step = lanes.step()
        verdicts.append([shown.verdict for shown in step.shown])
    return verdicts


@pytest.mark.slow
@pytest.mark.parametrize("wait", WAITS)
def test_a_rig_between_the_borders_keeps_sticking_after_a_push(stock, wait):
    calm, pushed, back = told(stock, "bistability", wait)
    assert all(lane.mitigated for lane in calm)
    assert pushed[0].stuck > 0.0
    assert back[0].stuck > 0.0
    assert back[1].mitigated


@pytest.mark.slow
@pytest.mark.parametrize("wait", WAITS)
def test_a_speed_between_the_borders_frees_nothing(stock, wait):
    *held, last = told(stock, "above-critical", wait)
    assert all(lane.stuck > 0.0 for lane, _ in (*held, last))
    assert last[1].mitigated
