"""Mitigated share over the delay of measurements, a panel an environment and noise."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import Any

import numpy as np

from agents.noise_and_delay import TOLD, in_words
from agents.policy.action_zero import SAME_DRIVE
from drillrig_env.plots.style import BLUE, DARK, GREEN, GREY, PURPLE, VERMILLION, Picture, new_figure
from drillrig_env.scales import CONTROL_PERIOD

_BESIDE = {
    "`lqg`": (DARK, "-"),
    TOLD: (DARK, (0, (4, 2))),
    SAME_DRIVE: (VERMILLION, (0, (4, 2))),
}
_AGENTS = ((BLUE, "o"), (GREEN, "s"), (PURPLE, "^"), (GREY, "D"))
"""Colours and markers of the agents, in their order."""


def plot_noise_and_delay(content: Mapping[str, Any]) -> Picture:
    """Every policy's share of the suite `default`, as `agents.noise_and_delay` has found them."""
    panels = [
        (env_id, float(noise), policies)
        for env_id, by_noise in content["environments"].items()
        for noise, policies in by_noise.items()
    ]
    figure = new_figure(4.6)
    seconds = np.array(content["delays"]) * CONTROL_PERIOD
    axes = figure.subplots(2, -(-len(panels) // 2), sharex=True, sharey=True, squeeze=False)
    agents = dict.fromkeys(name for *_, policies in panels for name in policies if name not in _BESIDE)
    looks: dict[str, tuple[str, str, Any]] = {
        name: (*look, "-") for name, look in zip(agents, cycle(_AGENTS), strict=False)
    }
    looks |= {name: (colour, "o", style) for name, (colour, style) in _BESIDE.items()}
    handles: dict[str, Any] = {}
    for panel, (env_id, noise, policies) in zip(axes.flat, panels, strict=True):
        for name, found in policies.items():
            colour, marker, style = looks[name]
            (line,) = panel.plot(seconds, found, color=colour, ls=style, marker=marker, ms=3, lw=1.4)
            handles.setdefault(name.replace("`", ""), line)
        panel.set_title(f"{env_id}\n{in_words(noise)}")
        panel.set_ylim(-0.02, 1.02)
    for panel in axes[-1]:
        panel.set_xlabel("delay of measurements, s")
    for row in axes:
        row[0].set_ylabel("share mitigated")
    figure.legend(handles.values(), handles.keys(), loc="outside upper center", ncols=4)
    caption = (
        f"Mitigated share of the {content['rigs']:,} rigs of the suite default over the delay of their measurements. "
        "One lqg is as it comes, the other (dashed) is told the delay; the agents are told nothing."
    )
    return Picture(figure, caption)
