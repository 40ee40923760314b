"""A study on disk: every try with what was drawn and what it was worth, to go on from after any stop.

| file | holds |
|---|---|
| `study.log` | Optuna's journal: all tries, also those that were cut |
| `study.json` | what the study is about; one that goes on must be about the same |
| `best.yml` | the hyperparameters of the best try, as `train.py --conf-file` takes them |
| `tries.md` | the ten best, with their seeds |
| `study.png` | the study as a picture |
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import yaml

from agents.tuning.space import seed_of
from agents.tuning.trial import Question
from agents.tuning.tries import STEPS, steps_of, worth
from drillrig_env.evaluation.provenance import in_words, provenance
from drillrig_env.extras import missing
from drillrig_env.files import json_text, read_json, write_text
from drillrig_env.markdown import table

JOURNAL, ABOUT, BEST, TRIES, PICTURE = "study.log", "study.json", "best.yml", "tries.md", "study.png"
NAME = "drillrig"
_BEST = 10
_FULL = 0.9
"""Share of the steps from which on a try has gone to its end: rollouts do not end with the last look."""


def optuna_module() -> Any:
    """The package; `ImportError` with what to install where it is missing."""
    try:
        import optuna
    except ImportError:
        raise missing("tuning", "optuna", "scale") from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    return optuna


class Study:
    """The study in a folder, begun or gone on with. `ValueError` where one that is there is about something else."""

    def __init__(self, folder: Path, question: Question) -> None:
        self.folder, self.question = folder, question
        optuna = optuna_module()
        definition = json.loads(json_text(question.definition()))
        if (folder / ABOUT).exists():
            held = read_json(folder / ABOUT, "remove the folder")
            for name, value in definition.items():
                if held.get(name) != value:
                    raise ValueError(f"{folder} is a study of another {name}; name another folder, or ask the same")
        folder.mkdir(parents=True, exist_ok=True)
        write_text(folder / ABOUT, json_text(definition))
        backend = optuna.storages.journal.JournalFileBackend(str(folder / JOURNAL))
        self.storage: Any = optuna.storages.JournalStorage(backend)
        pruner = optuna.pruners.SuccessiveHalvingPruner(question.first_look, reduction_factor=3)
        self.optuna: Any = optuna.create_study(
            storage=self.storage,
            study_name=NAME,
            pruner=pruner,
            direction="maximize",
            load_if_exists=True,
        )
        tries = len(self.optuna.get_trials(deepcopy=False))  # one that goes on is not to draw the first tries again
        self.optuna.sampler = optuna.samplers.TPESampler(seed=question.base["seed"] + tries, n_startup_trials=10)
        if not tries:  # what the file has already is what others are to be better than
            self.optuna.enqueue_trial(question.space.own())

    def take_up_cut(self) -> int:
        """Put tries that a kill has cut in front of those to come, and say how many there are."""
        states = optuna_module().trial.TrialState
        cut = self.optuna.get_trials(states=(states.RUNNING,))
        for trial in cut:
            self.storage.set_trial_state_values(trial._trial_id, states.FAIL)
            self.optuna.enqueue_trial(trial.params)
        return len(cut)

    @property
    def done(self) -> list[Any]:
        """Tries that have a worth, those that were ended early among them, as they were begun."""
        states = optuna_module().trial.TrialState
        return [
            trial
            for trial in self.optuna.get_trials(deepcopy=False, states=(states.COMPLETE, states.PRUNED))
            if trial.value is not None or trial.intermediate_values
        ]

    @property
    def spent(self) -> int:
        """Steps of the environment that all tries have taken."""
        return sum(int(trial.user_attrs.get(STEPS, 0)) for trial in self.done)

    def is_full(self, trial: Any) -> bool:
        """Whether a try went to its end."""
        return steps_of(trial) >= _FULL * self.question.steps

    def best_first(self) -> list[Any]:
        """Tries that went to their end, the best first; then those that were ended early."""
        return sorted(self.done, key=lambda one: (not self.is_full(one), -worth(one)))

    def write(self, picture: bool = True) -> None:
        """Write what was found: the best hyperparameters, the ten best tries, and the picture, which takes longest."""
        found = self.best_first()
        if not found:
            return
        question, best = self.question, found[0]
        base, env_id = question.base, question.base["env_id"]
        merged = {**question.chosen(best.params), "env_kwargs": base["env_kwargs"]}
        seed = seed_of(best.params, base["seed"])
        head = (
            f"# Found by a study of {len(found)} tries, {self.spent:,} steps; {question.objective} "
            f"{worth(best):.4f} on {question.rigs} rigs for validation of the suite {question.suite}, with the "
            f"training seed {seed}.\n# {in_words(provenance())}\n"
        )
        text = yaml.safe_dump({env_id: json.loads(json_text(merged))}, sort_keys=False, allow_unicode=True)
        write_text(self.folder / BEST, head + text)
        write_text(self.folder / TRIES, self.table() + "\n")
        if picture:
            from agents.tuning.picture import draw_study

            draw_study(self, self.folder)

    def table(self) -> str:
        """The ten best tries, with their seeds."""
        names = [one.name for one in self.question.space.dimensions]
        rows = []
        for trial in self.best_first()[:_BEST]:
            values = [_text(one.value(trial.params[one.name])) for one in self.question.space.dimensions]
            seed = seed_of(trial.params, self.question.base["seed"])
            rows.append([str(trial.number), f"{worth(trial):.4f}", f"{steps_of(trial):,}", str(seed), *values])
        return table(["try", self.question.objective, "steps", "seed", *names], rows)


def _text(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
