"""A training on a calibrated rig: on the half of its draws that is learnt on, never on the half that is judged on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import drillrig_env
from drillrig_env.calibrate.posterior import Posterior
from drillrig_env.env.scenario import Scenario
from drillrig_env.rig import RIGS
from drillrig_env.scales import Scales


def posterior_of(rig: Any) -> Posterior | None:
    """The calibration that a rig stands for, as trainings are given one: of a folder what it holds, else None."""
    if not isinstance(rig, str | Path) or rig in RIGS or not Path(rig).is_dir():
        return None
    return Posterior.from_folder(rig)


def calibrated_arguments(
    posterior: Posterior, env_id: str, usual: Mapping[str, Any], own: Mapping[str, Any], scales: Scales
) -> dict[str, Any]:
    """Rig and scenario of an environment on `posterior.training`, as plain values.

    `usual` are arguments as hyperparameters have them, on a rig with these scales, and `own` those that the training
    itself is given, whose dictionary of a scenario keeps what it gives. `ValueError` where that gives rigs.
    """
    given = own.get("scenario")
    if (given.get("rigs") if isinstance(given, Mapping) else getattr(given, "rigs", None)) is not None:
        raise ValueError(f"the scenario's rigs and {posterior.folder} are both given; allowed: one of them")
    usual_one = usual.get("scenario", drillrig_env.ENVIRONMENTS.get(env_id, {}).get("scenario", "default"))
    scenario = own.get("scenario", Scenario.named(usual_one, scales))
    return {"rig": posterior.rig, "scenario": calibrated_scenario(posterior, scenario, scales)}


def calibrated_scenario(
    posterior: Posterior, scenario: str | Mapping[str, Any] | Scenario, scales: Scales
) -> dict[str, Any]:
    """A scenario on the rigs to learn on, as plain values but for its rigs; a law of friction is its name or place."""
    made = posterior.scenario(posterior.training, scenario, scales)
    return {**asdict(made), "friction": made.friction.as_dict()}
