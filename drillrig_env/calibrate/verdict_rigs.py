"""Suites on other rigs than the one that policies are designed for: those that records allow, or the one that turns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from drillrig_env.calibrate.posterior import Posterior, force_factor, scenario_on
from drillrig_env.evaluation.suites import OF_ONE_RIG, Suite
from drillrig_env.fleet import Fleet, is_stable_without_friction, with_gains_of
from drillrig_env.friction import Friction
from drillrig_env.parameters import refuse
from drillrig_env.rig import Rig


@dataclass(frozen=True, eq=False)
class VerdictRigs:
    """Rigs to be judged on, with the friction of the middle one and the largest load (N); `words` say which they are.

    The drive of each is set as that of the nominal rig, which policies are designed for.
    """

    rigs: Fleet
    friction: Friction
    load: float
    words: str

    @classmethod
    def of(
        cls, file: str | Path | None, posterior: Posterior | None, nominal: Rig, suites: Sequence[str]
    ) -> VerdictRigs | None:
        """Those of a `file`, else of a calibration, for suites by name; None where there is neither.

        Raises as `of_file` and `of_posterior` do, and `ValueError` for a file beside a suite with rigs of its own.
        """
        if file is None:
            return None if posterior is None else cls.of_posterior(posterior)
        for name in suites:
            if name not in OF_ONE_RIG:
                raise ValueError(f"the suite {name} has rigs of its own; allowed on a rig: {', '.join(OF_ONE_RIG)}")
        return cls.of_file(file, nominal)

    @classmethod
    def of_posterior(cls, posterior: Posterior) -> VerdictRigs:
        """The rigs that records allow and that nothing was trained on.

        `ValueError` where nothing is known of the friction, and where the drive turns too few of the draws steadily.
        """
        posterior.check_load()
        rigs = posterior.judged
        words = f"{len(rigs.rigs)} rigs that the records of {posterior.name} allow"
        return cls(rigs, posterior.friction, posterior.load, words)

    @classmethod
    def of_file(cls, path: str | Path, nominal: Rig) -> VerdictRigs:
        """One rig, of a file with the tables [rig] and [friction] or a folder with both files.

        N_1 of the friction is the largest that is drawn. `ValueError` for what is not allowed, where that is 0, and
        where the rig does not turn steadily with the drive of `nominal`; `FileNotFoundError` where there is no such
        file.
        """
        rig, friction = Rig.of(path), Friction.of(path).single()
        load = float(np.asarray(friction.normal_force))
        if not load > 0.0:
            raise refuse(str(path), "normal_force", load, "N", "> 0, the largest that is drawn")
        if not is_stable_without_friction(with_gains_of(rig, nominal)):
            gains = f"k_p = {nominal.k_p:.4g} V s/rad, k_i = {nominal.k_i:.4g} V/rad"
            raise ValueError(f"{path}: the rig does not turn steadily with the drive that is set, {gains}")
        return cls(Fleet(rigs=(rig,)), friction, load, f"the rig of {Path(path).name}")

    def suite(self, suite: Suite) -> Suite:
        """A suite whose episodes take these rigs in turn, with their friction and loads.

        `suite` is one of the nominal rig with its scales. A suite of a fleet keeps its own rigs, which are drawn around
        the nominal one: rigs that are known worse than these.
        """
        factor, first, groups = force_factor(self.load, suite.scales), 0, []
        own = suite.scenario.rigs is not None
        for count, options in suite.groups:
            found: dict[str, Any] = dict(options)
            if "normal_force" in found:
                found["normal_force"] = found["normal_force"] * factor
            if "load_steps" in found:
                found["load_steps"] = [(time, force * factor) for time, force in found["load_steps"]]
            if not own:
                found["rig"] = np.arange(first, first + count) % len(self.rigs.rigs)
            groups.append((count, found))
            first += count
        rigs = suite.scenario.rigs or self.rigs
        scenario = scenario_on(rigs, self.friction, self.load, suite.scenario, suite.scales)
        told = suite.description if own else f"{suite.description}, on {self.words}"
        return replace(suite, description=told, scenario=scenario, groups=tuple(groups))
