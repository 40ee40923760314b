"""Suites on a calibrated rig: the same cases, on rigs that its records allow and that nothing was trained on."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from drillrig_env.calibrate.posterior import Posterior
from drillrig_env.evaluation.suites import Suite


def judged_suite(suite: Suite, posterior: Posterior) -> Suite:
    """A suite whose episodes take the rigs of `posterior.judged` in turn, with its friction and loads.

    `suite` is one of the rig with its scales. A suite of a fleet keeps its own rigs, which are drawn around the best
    fit: rigs that are known worse than this one. `ValueError` where nothing is known of the friction, and where the
    drive turns too few of the draws steadily.
    """
    posterior.check_load()
    factor, first, groups = posterior.force_factor(suite.scales), 0, []
    own = suite.scenario.rigs is not None
    rigs = suite.scenario.rigs or posterior.judged
    count_of_rigs = len(rigs.rigs)
    for count, options in suite.groups:
        found: dict[str, Any] = dict(options)
        if "normal_force" in found:
            found["normal_force"] = found["normal_force"] * factor
        if "load_steps" in found:
            found["load_steps"] = [(time, force * factor) for time, force in found["load_steps"]]
        if not own:
            found["rig"] = np.arange(first, first + count) % count_of_rigs
        groups.append((count, found))
        first += count
    told = "" if own else f", on {count_of_rigs} rigs that the records of {posterior.name} allow"
    scenario = posterior.scenario(rigs, suite.scenario, suite.scales)
    return replace(suite, description=suite.description + told, scenario=scenario, groups=tuple(groups))
