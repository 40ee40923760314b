"""One try: a training with what was drawn, and what its agent is worth on the way."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from agents.training.hyperparameters import hyperparameters
from agents.training.settings import Training, checked_config
from agents.training.train import try_out
from agents.training.warm_up import steps_held
from agents.tuning.objective import Watch, objective_named, validation_suite, worth_of
from agents.tuning.space import Space, seed_of
from drillrig_env.evaluation.suites import home_suite

_LOOKS = 10
"""Times that a try is looked at on its way."""


@dataclass(frozen=True)
class Question:
    """What is asked of each try: the `base`, a training's config around what is drawn, and by what it is judged.

    It holds all that a try needs, so that it can travel to machines that have no file of the user's.
    """

    base: Mapping[str, Any]
    space: Space
    objective: str
    suite: str
    rigs: int
    threads: int | None = None

    @classmethod
    def of(cls, training: Training, objective: str = "worth", suite: str | None = None, rigs: int = 500) -> Question:
        """Of a training, by default on rigs as its environment has them.

        `ValueError` for what is not allowed, and where its file has nothing to look through.
        """
        objective_named(objective)
        suite = home_suite(training.env_id) if suite is None else suite
        validation_suite(suite, rigs)
        space = Space.of(training.algorithm, training.env_id, training.conf_file)
        base = checked_config(replace(training, eval_freq=-1, save_freq=10**12, tensorboard=False))
        return cls(base, space, objective, suite, rigs, training.threads)

    @property
    def steps(self) -> int:
        """The length of a try that is not ended early, in steps of the environment."""
        return int(self.base["hyperparameters"]["n_timesteps"])

    @property
    def every(self) -> int:
        """Steps between two looks at a try."""
        return max(1, self.steps // _LOOKS)

    @property
    def first_look(self) -> int:
        """Steps from which on a try may be ended: before its actor learns, all are worth what they have imitated."""
        held = steps_held(self.base["algorithm"], self.base["hyperparameters"])
        return min(held + self.every, self.steps)

    def config(self, drawn: Mapping[str, Any]) -> dict[str, Any]:
        """Everything that fixes the training of what was drawn. `ValueError` where that is not allowed."""
        return {**self.base, "hyperparameters": self.chosen(drawn), "seed": seed_of(drawn, self.base["seed"])}

    def chosen(self, drawn: Mapping[str, Any]) -> dict[str, Any]:
        """The hyperparameters with what was drawn put in. `ValueError` where that is not allowed."""
        base = self.base
        return hyperparameters(
            base["algorithm"], base["env_id"], self.space.changes(drawn), table=base["hyperparameters"]
        )

    def definition(self) -> dict[str, Any]:
        """What a study is about, as plain values: one that goes on must be about the same."""
        space = {one.name: [list(map(str, one.choices)), one.low, one.high, one.log] for one in self.space.dimensions}
        return {
            "training": {name: value for name, value in self.base.items() if name != "command"},
            "search": space,
            "objective": self.objective,
            "suite": self.suite,
            "validation_rigs": self.rigs,
        }

    def ask(self, drawn: Mapping[str, Any], told: Callable[[int, float], bool]) -> None:
        """Train what was drawn. `told` hears of steps and worth on the way and at the end, and may end it early."""
        config = self.config(drawn)
        watch = Watch(
            lambda model: worth_of(model, config, self.objective, self.suite, self.rigs, self.threads),
            self.every,
            told,
        )
        with tempfile.TemporaryDirectory(prefix="drillrig-try-") as folder:
            try_out(config, Path(folder), [watch], self.threads)
