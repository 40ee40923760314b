"""Five guided stories, part by part: what a part sets, and what there is to see. The numbers are the chapter rig's.

A part may choose a setting, with which the run begins anew, and give values or ramps from then on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from drillrig_env.parameters import closest


@dataclass(frozen=True)
class Part:
    """A part of a story: a heading, a paragraph, and what is done when it is opened."""

    heading: str
    text: str
    setting: Mapping[str, Any] = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)
    ramps: tuple[tuple[str, float, float], ...] = ()  # name, where to, s


@dataclass(frozen=True)
class Story:
    """A story: its title and its parts."""

    title: str
    parts: tuple[Part, ...]


def _laboratory(**changes: Any) -> dict[str, Any]:
    """The chapter's rig as every story begins, with some changes."""
    plain = {"rig": "laboratory", "sensors": "state", "noise": 0.0, "delay": 0, "k_p": 3.0, "k_i": 1.0, "seed": 0}
    friction = {"normal_force": 10.0, "mu_s": 0.5, "mu_k": 0.306, "v_b": 1.0}
    return {**plain, **friction, **changes}


STORIES: dict[str, Story] = {
    "step-load": Story(
        "A step of the load",
        (
            Part(
                "Calm at 30 rpm",
                "Both rigs turn at 3.14 rad/s with 5 N on the bit. A holds its speed reference whatever happens; B has "
                "a controller, LQG. Both dots lie in the calm part of their maps.",
                _laboratory(a="constant", b="lqg", start="steady", speed_target=3.14, normal_force=5.0),
            ),
            Part(
                "The formation gets harder: 25 N at once",
                "Steady rotation at 3.14 rad/s is still stable, for the critical speed at 25 N is 2.91 rad/s. But the "
                "step throws the bit so far off that it sticks, and from there A does not come back. B sticks too, "
                "lets the string unwind, and is calm again after some 9 s.",
                values={"normal_force": 25.0},
            ),
            Part(
                "The same load, put on slowly",
                "Now N₁ rises to 25 N within 30 s. Nothing throws the bit off, and A stays calm, at the very same "
                "force, friction and speed at which it stuck before.",
                _laboratory(a="constant", b="lqg", start="steady", speed_target=3.14, normal_force=5.0),
                ramps=(("normal_force", 25.0, 30.0),),
            ),
        ),
    ),
    "bistability": Story(
        "Two answers to one question",
        (
            Part(
                "Calm at 2.5 rad/s and 10 N",
                "The dot lies between the two borders of the map: above the critical speed, 1.99 rad/s, and below the "
                "end of stick-slip, 2.90 rad/s. Here steady rotation is stable, and so is stick-slip. Both rigs began "
                "in steady rotation, and both keep it.",
                _laboratory(a="constant", b="lqg", start="steady", speed_target=2.5),
            ),
            Part(
                "A push: 25 N",
                "The force goes up. At 25 N steady rotation at 2.5 rad/s is no longer stable: the dot is beyond the "
                "solid border, and A sticks and slips. Wait until it does.",
                values={"normal_force": 25.0},
            ),
            Part(
                "And back to 10 N",
                "Not at once, but within 5 s, for a sudden step may by chance shake A loose. Then force, friction and "
                "speed reference are what they were in the beginning. B is calm, A sticks and slips on, for ever: what "
                "a rig does here depends on what happened to it before. In the plane of twist and speed A runs on the "
                "closed curve, and B rests at the point inside.",
                ramps=(("normal_force", 10.0, 5.0),),
            ),
        ),
    ),
    "past-the-fold": Story(
        "Past the fold, and back",
        (
            Part(
                "A rig that sticks at 2.5 rad/s",
                "Both rigs begin in stick-slip. B has LQG and frees itself. A holds its reference, and stays where it "
                "is: its closed curve is stable.",
                _laboratory(a="constant", b="lqg", start="stick_slip", speed_target=2.5),
            ),
            Part(
                "Faster, past the fold: 3.2 rad/s",
                "Beyond 2.90 rad/s, the dashed border, there is no stick-slip left that A could run on. The bit is "
                "free, but the oscillation dies slowly: give it half a minute.",
                ramps=(("speed_target", 3.2, 5.0),),
            ),
            Part(
                "And back to 2.5 rad/s",
                "The dot is where it was in the beginning, and A is calm now. That is what drillers do by hand: speed "
                "up until it lets go, then ease back.",
                ramps=(("speed_target", 2.5, 5.0),),
            ),
        ),
    ),
    "above-critical": Story(
        "Why just above the critical speed frees nothing",
        (
            Part(
                "A little faster than critical: 2.1 rad/s",
                "The critical speed is 1.99 rad/s, so at 2.1 rad/s steady rotation is stable. A holds that speed and "
                "sticks and slips all the same: it never comes near enough to steady rotation to be caught by it.",
                _laboratory(a="constant", b="jump_ease", start="stick_slip", speed_target=2.1),
            ),
            Part(
                "Faster still: 2.6 rad/s",
                "Not at once, but within 10 s, for a sudden step may by chance shake A loose. This is still below the "
                "end of stick-slip, 2.90 rad/s: the curve that A runs on has changed its shape, not its nature.",
                ramps=(("speed_target", 2.6, 10.0),),
            ),
            Part(
                "Where is the way out?",
                "B was freed on the way: it went past the fold for as long as it took and eased back. Linear stability "
                "says where a calm rig stays calm; only the fold says where a sticking one is freed.",
                ramps=(("speed_target", 2.1, 10.0),),
            ),
        ),
    ),
    "delay": Story(
        "An agent against soft torque, under delay",
        (
            Part(
                "What a drilling rig measures, 0.1 s late",
                "Below the critical speed, at 20 N and 2 rad/s: whoever does nothing sticks. A is a trained agent that "
                "sees current, voltage and torque at the top, noisy and late. B softens the drive itself and needs to "
                "see nothing. Both turn calmly after some 10 s.",
                _laboratory(
                    a="ppo_surface", b="soft_torque", sensors="surface", noise=1.0, delay=1, start="stick_slip",
                    speed_target=2.0, normal_force=20.0,
                ),
            ),
            Part(
                "Half a second late",
                "The agent was trained with delays up to this one, and was never told which it has. It takes a little "
                "longer. To the softened drive delay is nothing: it uses no measurement.",
                _laboratory(
                    a="ppo_surface", b="soft_torque", sensors="surface", noise=1.0, delay=5, start="stick_slip",
                    speed_target=2.0, normal_force=20.0,
                ),
            ),
            Part(
                "Others under the same delay",
                "LQG and the torque law of the industry see the same numbers half a second late. Both are lost: they "
                "push when they should give way.",
                _laboratory(
                    a="lqg", b="z_torque", sensors="surface", noise=1.0, delay=5, start="stick_slip",
                    speed_target=2.0, normal_force=20.0,
                ),
            ),
        ),
    ),
}  # fmt: skip
"""Every story by name."""


def part_of(name: str, part: int) -> Part:
    """A part of a story. `ValueError` for a story or a part that is not there."""
    if name not in STORIES:
        raise ValueError(f"story {name!r} is not known; {closest(name, STORIES)}")
    parts = STORIES[name].parts
    if not 0 <= part < len(parts):
        raise ValueError(f"story {name}: part {part} is not there; allowed: 0 to {len(parts) - 1}")
    return parts[part]
