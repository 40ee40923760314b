"""Train an agent on random rigs.

    python train.py                                        # PPO on DrillRig-v0
    python train.py ppo --n-timesteps 10000000 --seed 3
    python train.py ppo --env DrillRigSurface-v0 --seeds 5 --jobs 2
    python train.py sac --hyperparams batch_size:256 gamma:0.98
    python train.py ppo_asymmetric --env DrillRigUnknown-v0  # where nobody knows the rig: a memory, and a told critic
    python train.py --rig my_rig.toml                      # on a rig of your own
    python train.py --rig my_rig                           # on rigs that a calibration allows, by its folder
    python train.py --resume runs/ppo_1                    # go on after Ctrl-C
    python train.py ppo --tune runs/study --budget-steps 3e7 --budget-hours 8
    python train.py ppo --conf-file runs/study/best.yml --seeds 5
    python eval.py constant jump_ease runs/ppo_1           # then compare it

With the folder of a calibration the rigs are half of its draws; `eval.py --rig` judges on the other half. Flags are
named as in rl-zoo3 where there is one. Ctrl-C finishes the rollout, saves and stops; a second one stops at once, and
training can go on from the last checkpoint. Exit codes: 0 done, 1 failed, 2 the arguments are not allowed, 130 stopped
by Ctrl-C, 143 by SIGTERM.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from drillrig_env.starting import imports_begin

if __name__ == "__main__":
    imports_begin()

# isort: split
from agents.policy.run_folder import is_run
from agents.training.hyperparameters import ALGORITHMS, read_pairs
from agents.training.seeds import resume_seeds, train_seeds
from agents.training.settings import Training
from agents.training.train import resume, train
from drillrig_env.allowed import COUNT, POSITIVE
from drillrig_env.command_line import Parser, command
from drillrig_env.engine import LOCAL, Engine, engine_at
from drillrig_env.flags import add_engine_arguments, add_fields, add_rig_argument, of_kind

_FLAGS = {
    "env_id": ("--env",),
    "n_timesteps": ("-n", "--n-timesteps"),
    "log_folder": ("-f", "--log-folder"),
    "conf_file": ("-conf", "--conf-file"),
}
_PAIRS = {"hyperparams": ("-params", "--hyperparams"), "env_kwargs": ("--env-kwargs",)}
"""Flags of the fields of `Training` that are not just the field's name."""

_OF_TUNING = ("tune", "budget_steps", "budget_hours", "objective", "objective_suite", "objective_rigs")

_TRIES = 20
"""Trainings that a study has steps for where it is not told."""

_WITH_RESUME = ("resume", "threads", "on", "jobs", "progress")


@command
def main(arguments: Sequence[str] | None = None, prog: str = "python train.py") -> None:
    """Parse the command line and train."""
    parser = argument_parser(prog)
    given = {name: value for name, value in vars(parser.parse_args(arguments)).items() if value is not None}
    try:
        folder = _go_on(parser, given) if "resume" in given else _begin(given)
    except (ValueError, ImportError, FileNotFoundError) as error:
        parser.error(error)
    print(f"run folder: {folder}")


def _begin(given: Mapping[str, Any]) -> Path:
    """Train what the flags say, and return its folder."""
    values = dict(given)
    seeds, algorithm = values.pop("seeds", 1), values.pop("algo", None)
    asked = {name: values.pop(name) for name in _OF_TUNING if name in values}
    engine = engine_at(values.pop("on"), values.pop("jobs", None))
    if algorithm and values.setdefault("algorithm", algorithm) != algorithm:
        raise ValueError(f"--algo {algorithm} and {values['algorithm']} contradict each other")
    for name in _PAIRS:
        if name in values:
            values[name] = read_pairs(values[name])
    if "rig" in values:
        rig = values.pop("rig")
        values["env_kwargs"] = {"rig": values.pop("calibration", rig)} | values.get("env_kwargs", {})
    training = Training(**values)
    if "tune" in asked:
        if seeds > 1:
            raise ValueError("--tune is given with --seeds; each try has a seed of its own")
        return _tune(training, engine, asked)
    if asked:
        raise ValueError(f"--{next(iter(asked)).replace('_', '-')} is given without --tune")
    if seeds > 1:
        return train_seeds(training, seeds, engine)
    if engine.where != LOCAL:
        raise ValueError(f"--on {engine.where} is given without --seeds; one training is done on this machine")
    return train(training)


def _tune(training: Training, engine: Engine, asked: Mapping[str, Any]) -> Path:
    """Search hyperparameters, print the ten best tries, and return the study's folder."""
    from agents.tuning.search import search
    from agents.tuning.trial import Question

    folder, hours = asked["tune"], asked.get("budget_hours")
    names = {"objective": "objective", "objective_suite": "suite", "objective_rigs": "rigs"}
    question = Question.of(training, **{names[name]: asked[name] for name in names if name in asked})
    steps = asked.get("budget_steps", _TRIES * question.steps)
    study = search(folder, question, steps, hours, engine, progress=training.progress)
    print(study.table())
    best = f"python train.py {training.algorithm} --env {training.env_id} --conf-file {folder / 'best.yml'}"
    print(f"to train with the best: {best} --seeds 5")
    return Path(folder)


def _go_on(parser: argparse.ArgumentParser, given: Mapping[str, Any]) -> Path:
    """Go on with a run or with a folder of runs; what they are is written there, and no flag may say otherwise."""
    flags = {action.dest: (action.option_strings or [action.dest])[-1] for action in parser._actions}
    others = [flags[name] for name in given if name not in _WITH_RESUME]
    if others:
        allowed = ", ".join(flags[name] for name in _WITH_RESUME if name != "resume")
        raise ValueError(f"--resume goes on as config.json says, without {', '.join(others)}; allowed: {allowed}")
    run, threads, progress = given["resume"], given.get("threads"), given.get("progress", True)
    engine = engine_at(given["on"], given.get("jobs"))
    if is_run(run):
        return resume(run, threads, progress)
    return resume_seeds(run, engine, threads, progress)


def argument_parser(prog: str) -> Parser:
    """The command line: a flag for every field of `Training`. What is not given is not among the arguments."""
    parser = Parser(prog=prog, description=__doc__, argument_default=argparse.SUPPRESS)
    add = parser.add_argument
    add("algorithm", nargs="?", default=None, choices=list(ALGORITHMS), help="the algorithm (default: ppo)")
    add("--algo", choices=list(ALGORITHMS), help="the same, as rl-zoo3 has it")
    add_rig_argument(parser)
    add_fields(parser, Training, skip=("algorithm", "hyperparams", "env_kwargs"), flags=_FLAGS)
    for name, flags in _PAIRS.items():
        meaning = Training.__dataclass_fields__[name].metadata["meaning"]
        add(*flags, nargs="+", dest=name, metavar="NAME:VALUE", help=meaning)
    add("--seeds", type=of_kind(COUNT), help="train this many seeds, from --seed on, into <run folder>/seed_<s>")
    add_engine_arguments(parser, "seeds")
    _add_tuning(parser)
    add("--resume", type=Path, metavar="RUN", help="go on with a stopped run, or with the seeds in a folder")
    return parser


def _add_tuning(parser: Parser) -> None:
    """The flags of a search."""
    add = parser.add_argument_group("search of hyperparameters").add_argument
    add(
        "--tune",
        type=Path,
        metavar="DIR",
        help="search what the file of hyperparameters has under `search`, or go on with the study in the folder",
    )
    add(
        "--budget-steps",
        type=of_kind(COUNT),
        metavar="STEPS",
        help=f"steps of the environment after which no further try begins (default: {_TRIES} trainings)",
    )
    add("--budget-hours", type=of_kind(POSITIVE, "h"), metavar="H", help="and no longer than so (default: no limit)")
    objectives = "mitigated, calm, reward, time_to_calm"
    add("--objective", metavar="NAME", help=f"worth (share mitigated less a tenth of the mean cost), {objectives}")
    add(
        "--objective-suite",
        metavar="NAME",
        help="draws as in this suite, of rigs for validation (default: the environment's)",
    )
    add("--objective-rigs", type=of_kind(COUNT), metavar="N", help="so many (default: 500)")


if __name__ == "__main__":
    raise SystemExit(main())
