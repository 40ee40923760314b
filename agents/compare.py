"""Train settings beside each other, several seeds of each, and score all of them on the same rigs.

    python -m agents.compare ablations                       # a recipe for `ppo`, one piece changed at a time
    python -m agents.compare newcomer                        # Stable-Baselines3's own settings
    python -m agents.compare unknown                         # where nobody knows the rig
    python -m agents.compare ablations --settings recipe sum # some of it
    python -m agents.compare unknown --settings alone --steps 20000 --rigs 4 --runs /tmp/few --output /tmp/few.json
    python -m agents.compare ablations --steps 20000 --seeds 2 --rigs 50 --runs /tmp/runs --output /tmp/quick.json

Each training is one of `train.py`, in a run folder of its own, and goes on after Ctrl-C when the command is given
again. Given twice at a time, in two terminals, the trainings are shared out: each process takes the next that none
has. Every agent is scored on rigs of the training side (`VALIDATION_SEEDS`) drawn as in the suites `default`, `wide`
and `load`, those of `unknown` as in that suite, on a fleet of other rigs; the rigs of the suites stay unseen. The cost
is that of the environment's default reward for all. The file is written after each training; what it holds is not
repeated, unless the setting has changed since. It is of one comparison, and of one number of rigs.
"""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from agents.compared import Compared, evaluate
from agents.policy.action_zero import SAME_DRIVE
from agents.policy.finding import at_slew_limit
from agents.policy.run_folder import is_finished, is_run, load_policy, read_config
from agents.setting import ScoredOn, Setting
from agents.training.device import DEVICES
from agents.training.progress import read_progress
from agents.training.settings import checked_config
from agents.training.train import resume, train
from agents.variants import COMPARISONS, SCORED_ON
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Failed, Parser, command
from drillrig_env.files import check_writable, check_writable_file, owned
from drillrig_env.flags import of_kind
from drillrig_env.parameters import closest, refuse

COMMAND = "python -m agents.compare"
SEEDS, RIGS = 3, 1000

BESIDE = {"constant": SAME_DRIVE, "lqg": "`lqg`, same drive"}
"""Policies that are scored on the same rigs, and what a table calls them."""

_TAKEN = ".taken"  # holds a folder a training, which a process has while it trains and scores

_MADE_BY = ("algorithm", "env_id", "env_kwargs", "hyperparameters")
"""Entries of a training's config that must agree for it to be the same training, but for its seed."""


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Parse the command line, train what is missing, and write the file."""
    parser = Parser(prog=COMMAND, description=__doc__)
    parser.add_argument("comparison", choices=list(COMPARISONS), help="what is compared")
    parser.add_argument("--settings", nargs="+", metavar="NAME", help="which of its settings (default: all)")
    parser.add_argument("--steps", type=of_kind(COUNT), help="of each training (default: the setting's own)")
    parser.add_argument("--seeds", type=of_kind(COUNT), default=SEEDS, help=f"of each setting (default: {SEEDS})")
    parser.add_argument("--rigs", type=of_kind(COUNT), default=RIGS, help=f"of a kind to score on (default: {RIGS})")
    parser.add_argument("--threads", type=of_kind(COUNT), default=1, help="threads that step the rigs (default: 1)")
    parser.add_argument("--device", choices=DEVICES, default="cpu", help="what PyTorch trains on (default: cpu)")
    parser.add_argument("--runs", type=Path, help="folder of the trainings (default: runs/COMPARISON)")
    parser.add_argument("--output", type=Path, help="file to write (default: docs/agents/COMPARISON.json)")
    chosen = parser.parse_args(arguments)
    line = shlex.join([*COMMAND.split(), *(sys.argv[1:] if arguments is None else arguments)])
    runs = chosen.runs or Path("runs") / chosen.comparison
    output = chosen.output or Path("docs") / "agents" / f"{chosen.comparison}.json"
    settings = COMPARISONS[chosen.comparison]()
    changes: dict[str, Any] = {"device": chosen.device, **({"n_timesteps": chosen.steps} if chosen.steps else {})}
    settings = [replace(one, training=replace(one.training, **changes)) for one in settings]
    kept = Compared(output, runs, [one.name for one in settings], line, chosen.comparison)
    check_writable_file(output)
    check_writable(runs)
    try:
        scored_on = SCORED_ON.get(chosen.comparison)
        compare(_named(settings, chosen.settings), chosen.seeds, chosen.rigs, kept, runs, chosen.threads, scored_on)
    except ValueError as error:
        parser.error(error)
    except KeyboardInterrupt as stop:
        if output.is_file():
            stop.add_note(f"what was finished is in {output}")
        stop.add_note(f"to go on with all: {line}")
        raise
    print(output.resolve())


def _named(settings: Sequence[Setting], names: Sequence[str] | None) -> list[Setting]:
    """The settings of those names, or all. `ValueError` for an unknown name."""
    known = {setting.name: setting for setting in settings}
    for name in names or ():
        if name not in known:
            raise ValueError(f"setting {name!r} is not known; {closest(name, known)}")
    return [known[name] for name in names or known]


def compare(
    settings: Sequence[Setting],
    seeds: int,
    rigs: int,
    kept: Compared,
    runs: Path,
    threads: int | None = 1,
    scored_on: ScoredOn | None = None,
) -> None:
    """Train and score what `kept` does not hold yet: the first seed of every setting, then the second, and so on.

    The trainings lie in `runs`/<setting>_<seed>; one that another process is at is passed over, and one that was
    stopped goes on. What they are scored on is that of `scored_on`, or the suites of one rig. Raises `ValueError` for
    numbers below 1, for a setting that a training refuses, for a file that is damaged or of another comparison or other
    rigs, and for a folder that holds a training of another setting, before anything is trained; `Failed` at the end,
    naming the trainings that failed.
    """
    for name, value in (("seeds", seeds), ("rigs", rigs)):
        if value < 1:
            raise refuse("compare", name, value, "", ">= 1")
    kept.check(rigs)
    abouts = {setting.name: _about(setting, rigs) for setting in settings}
    left = [(setting, seed, runs / f"{setting.name}_{seed}") for seed in range(seeds) for setting in settings]
    for setting, _, folder in left:
        about = abouts[setting.name]
        if is_run(folder) and any(read_config(folder)[name] != about[name] for name in _MADE_BY):
            raise ValueError(f"{folder} holds a training of another setting; remove it, or name other --runs")
    suites = None if scored_on is None else scored_on.suites
    _beside(rigs, kept, threads, scored_on or ScoredOn(None, "state", BESIDE))
    failed = []
    for number, (setting, seed, folder) in enumerate(left, 1):
        label = f"{number}/{len(left)} {setting.name}, seed {seed}"
        try:
            told = _one(setting, abouts[setting.name], seed, folder, kept, threads, suites)
        except BlockingIOError as taken:
            told = str(taken)
        except Failed as failure:
            failed.append(f"{setting.name}, seed {seed}")
            told = "; ".join([str(failure), *getattr(failure, "__notes__", [])])
        print(f"{label}: {told}", flush=True)
    if failed:
        raise Failed(f"training failed for {'; '.join(failed)}; what it said is above")


def _one(
    setting: Setting,
    about: Mapping[str, Any],
    seed: int,
    run: Path,
    kept: Compared,
    threads: int | None,
    suites: Sequence[str] | None,
) -> str:
    """Train a seed of a setting, or go on with it, score it and keep that; what is to be told of it."""
    with owned(run.parent / _TAKEN / run.name):
        if kept.has(setting.name, about, seed):
            return "done before"
        if not is_run(run):
            train(replace(setting.training, seed=seed, run_folder=run, threads=threads))
        elif not is_finished(run):
            resume(run, threads)
        seconds = read_progress(run).get("seconds")
        if seconds is None:
            raise Failed(f"{run} does not tell how long it was trained; remove it, and it is trained again")
        agent = load_policy(run)
        scores = evaluate(at_slew_limit(agent), agent.environment["sensors"], about["rigs"], threads, suites)
        machine = read_config(run)["provenance"]["machine"]
        kept.keep(setting.name, about, seed, {"seconds": seconds, "machine": machine, "scores": scores})
    shown = ", ".join(f"{name} {one['mitigated']:.3f}" for name, one in scores.items())
    return f"mitigated {shown}; trained in {seconds:.0f} s"


def _about(setting: Setting, rigs: int) -> dict[str, Any]:
    """What must agree for a seed of a setting to count as done, as the file has it."""
    config = json.loads(json.dumps(checked_config(setting.training)))
    return {"words": setting.words, "rigs": rigs, **{name: config[name] for name in _MADE_BY}}


def _beside(rigs: int, kept: Compared, threads: int | None, on: ScoredOn) -> None:
    """Score what stands beside the agents, in the environment as `gym.make` gives it, where that is not done yet."""
    for name, words in on.beside.items():
        if name not in kept.read()["beside"].get("policies", {}):
            scores = evaluate(name, on.sensors, rigs, threads, on.suites)
            kept.keep_beside(rigs, name, {"words": words, "scores": scores})


if __name__ == "__main__":
    raise SystemExit(main())
