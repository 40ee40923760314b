"""Compare policies on the same random rigs: tables in the terminal, a folder of results, pictures.

python eval.py                                        # the whole field on all suites
python eval.py --suite default --details              # one suite, all of its tables
python eval.py constant z_torque runs/ppo_1           # and a trained agent, by its run folder
python eval.py z_torque my_controller.py:MyPolicy     # and a controller of your own
python eval.py --env DrillRigSurface-v0 --output results/surface
python eval.py --from results                         # the tables and pictures again, without running

A policy is a baseline by name, the folder of a training run (or a trained agent that comes with the
package, by name), a folder of several runs of one algorithm (its training seeds, pooled), or
FILE.py:CLASS. Without names, every baseline and trained agent competes that can work with the
environment's sensors, slow ones excepted. A policy that fails is reported, and the others go on. Policies run one after
another: the rigs of a suite already share all cores.
"""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

import baselines
import drillrig_env
from drillrig_env.evaluation import histories as histories_of
from drillrig_env.evaluation.contest import Failure, check_same, config_of, run_contest
from drillrig_env.evaluation.contestants import find_contestants
from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.evaluation.report import print_suite
from drillrig_env.evaluation.results import Results, read
from drillrig_env.evaluation.suites import SUITES, Suite, suite
from drillrig_env.evaluation.tables import all_estimates
from drillrig_env.parameters import closest

EXAMPLE = '''\
from baselines import Baseline


class MyPolicy(Baseline):
    """Let the speed reference give way to the swing of the shaft's torque."""

    channels = ("speed_reference", "speed_target", "twist_23")
    memory = 1  # the running mean of the torque

    def desired_reference(self, seen, privileged, memory):
        torque = -self.rig.k_2 * seen["twist_23"]
        memory[:, 0] += 0.05 * (torque - memory[:, 0])
        return seen["speed_target"] - 8.0 * (torque - memory[:, 0])
'''
"""A user's own controller, as `--help` shows it."""

_EPILOG = f"""a controller of your own, my_controller.py:

{EXAMPLE}
  python eval.py constant z_torque my_controller.py:MyPolicy

`seen` holds physical values by the channels' names, one entry a rig. A class that is no Baseline needs
Stable-Baselines3's predict(observation, state, episode_start, deterministic) on batches, and is made
without arguments.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Parse the command line, put every policy through every suite, and report; the exit status."""
    parser = _parser()
    chosen = parser.parse_args(arguments)
    if chosen.saved:
        try:
            results, histories = read(chosen.saved), histories_of.read(chosen.saved)
        except ValueError as error:
            parser.error(str(error))
        reference = chosen.reference or results.config["reference"]
        for name in results.scores:
            _report(results, name, reference, chosen)
        _draw(results, histories, chosen.saved, chosen)
        return 0
    try:
        suites = [suite(name, chosen.rigs) for name in SUITES if name in chosen.suite]
    except ValueError as error:
        parser.error(str(error))
    contestants, failures = find_contestants(chosen.policies, chosen.env, chosen.slow)
    _print(failures)
    names = [contestant.name for contestant in contestants]
    reference = chosen.reference or next(iter(names), "")
    if names and reference not in names:
        parser.error(f"--reference {reference} is not among the policies that compete; {closest(reference, names)}")
    command = shlex.join(["python", "eval.py", *(sys.argv[1:] if arguments is None else arguments)])
    version = drillrig_env.__version__
    config = config_of(chosen.env, suites, contestants, version, command, reference)
    try:
        results, histories = _begin(chosen.output, config, chosen.resume)
    except ValueError as error:
        parser.error(str(error))
    try:
        for one in suites:
            with _progress() as bar:
                task = bar.add_task(one.name)
                failed = run_contest(
                    one, contestants, results, histories, chosen.output, partial(_show, bar, task, one)
                )
            _print(failed)
            failures += failed
            if one.name in results.scores:
                _report(results, one.name, reference, chosen)
    except KeyboardInterrupt:
        again = command if chosen.resume else f"{command} --resume"
        print(f"stopped; what was finished is in {chosen.output}; to go on: {again}")
        return 130
    if results.scores:
        results.estimates = all_estimates(results.scores, reference)
        results.save(chosen.output)
        _draw(results, histories, chosen.output, chosen)
    for failure in failures:
        print(f"error: {failure}", file=sys.stderr)
    return 1 if failures else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python eval.py",
        description=__doc__,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("policies", nargs="*", help=f"who competes; baselines: {', '.join(baselines.BASELINES)}")
    parser.add_argument("--env", choices=list(drillrig_env.ENVIRONMENTS), default="DrillRig-v0", help="whose sensors")
    parser.add_argument("--slow", action="store_true", help="without names, let slow policies (mppi) in as well")
    parser.add_argument("--suite", nargs="+", choices=list(SUITES), default=list(SUITES), help="default: all suites")
    parser.add_argument("--rigs", type=int, default=1000, help="random rigs of a suite that is drawn (default: 1000)")
    parser.add_argument(
        "--output", type=Path, default=Path("results"), help="folder for the results (default: results)"
    )
    parser.add_argument("--resume", action="store_true", help="go on with the results in the output folder")
    parser.add_argument(
        "--reference", metavar="NAME", help="policy that the others are compared with (default: the first)"
    )
    parser.add_argument(
        "--details", action="store_true", help="print also hardness, other scores and paired differences"
    )
    parser.add_argument("--no-pictures", action="store_true", help="draw nothing")
    parser.add_argument(
        "--from", dest="saved", type=Path, metavar="DIR", help="report the results of a folder; run nothing"
    )
    return parser


def _begin(folder: Path, config: dict[str, Any], resume: bool) -> tuple[Results, Histories]:
    """The results to add to: empty ones, or with `resume` those of the folder, if they are of the same making."""
    if not resume or not (folder / "results.json").exists():
        return Results(config, provenance()), Histories()
    results, histories = read(folder), histories_of.read(folder)
    check_same(results.config, config, folder)
    merged = {name: {**config[name], **results.config[name], **config[name]} for name in ("suites", "policies")}
    results.config, results.provenance = {**config, **merged}, provenance()
    return results, histories


def _report(results: Results, name: str, reference: str, chosen: argparse.Namespace) -> None:
    about = results.config["suites"][name]
    title = f"{name}: {about['description']} ({about['rigs']} rigs, {results.config['env']})"
    print_suite(title, results.scores[name], results.marks, reference, chosen.details, bool(chosen.reference))


def _draw(results: Results, histories: Histories, folder: Path, chosen: argparse.Namespace) -> None:
    if not chosen.no_pictures:
        from drillrig_env.evaluation.pictures import draw_all

        draw_all(results, histories, folder)
    print(f"results.csv, results.json{'' if chosen.no_pictures else ', pictures'}: {folder.resolve()}")


def _progress() -> Progress:
    return Progress(TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn(), transient=True)


def _show(bar: Progress, task: Any, suite: Suite, policy: str, done: int, of: int) -> None:
    bar.update(task, description=f"{suite.name}: {policy}", completed=done, total=of)


def _print(failures: Sequence[Failure]) -> None:
    """Failures as they happen, each with the innermost calls of its traceback."""
    for failure in failures:
        print(f"error: {failure}\n{failure.trace}".rstrip(), file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
