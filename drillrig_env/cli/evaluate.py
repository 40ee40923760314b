"""Compare policies on the same random rigs: tables in the terminal, a folder of results, pictures.

  drillrig evaluate                                     # everyone on all suites of one rig
  drillrig evaluate --suite default --details           # one suite, all of its tables
  drillrig evaluate constant z_torque runs/ppo_1        # and a trained agent, by its run folder
  drillrig evaluate z_torque my_controller.py:MyPolicy  # and a controller of your own
  drillrig evaluate --env DrillRigSurface-v0 --output results/surface
  drillrig evaluate --env DrillRigUnknown-v0            # on fleets of rigs that nobody knows
  drillrig evaluate --rig my_rig.toml                   # on a rig of your own
  drillrig evaluate --rig my_rig --suite default        # on rigs that a calibration allows, by its folder
  drillrig evaluate --suite default --rigs 100000 --on ray  # in pieces, side by side
  drillrig evaluate --from results                      # the tables and pictures again, without running

In a clone, `python eval.py` is the same. A policy is an installed one by name, the folder of a training run (or a
trained agent of the clone, by name), a folder of several runs of one algorithm (its training seeds, pooled), or
FILE.py:CLASS. Without names, every installed policy and trained agent competes that can work with the
environment's sensors, slow ones excepted. A policy that fails is reported, and the others go on. Policies run one after
another: the rigs of a suite already share all cores. Beyond one machine --on has a Ray cluster do them, with the same
results; see docs/scale.md. Of suites of more than 10,000 rigs rows are kept in Parquet files (extra `scale`).

Results that are there are never written over unasked. The same command again makes the same files again; where
there is anything that it would not make again it is refused, and --resume keeps that, --overwrite replaces it. Named
agents bring environment, noise and delay of their training, for everyone alike; where theirs differ, or --env says
otherwise, everyone meets the standard ones. A line tells of each agent what is not as in its training.

With the folder of a calibration policies are designed for its best fit, and judged on half of its draws, the half that
`train.py --rig` never shows; loads reach up to the largest of the records.
"""

from __future__ import annotations

import argparse
import importlib
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

import drillrig_env
from drillrig_env.allowed import COUNT, POSITIVE
from drillrig_env.calibrate.posterior import Posterior
from drillrig_env.calibrate.verdict_rigs import VerdictRigs
from drillrig_env.command_line import DONE, FAILED, Parser, command
from drillrig_env.engine import Engine
from drillrig_env.env.steady import check_steady
from drillrig_env.evaluation.beginning import begin
from drillrig_env.evaluation.contest import Contestant, Failure, config_of, run_contest
from drillrig_env.evaluation.contestants import find_contestants
from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.large import check_large
from drillrig_env.evaluation.provenance import note_processors
from drillrig_env.evaluation.report import print_suite
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.run_again import suite_of
from drillrig_env.evaluation.store import clear_pictures, read, read_histories, save
from drillrig_env.evaluation.suites import LARGE, OF_ONE_RIG, PIECE, SUITES, Suite, meant_for, suite
from drillrig_env.evaluation.tables import all_estimates
from drillrig_env.files import check_writable, owned
from drillrig_env.flags import add_engine_arguments, add_rig_argument, engine_of, of_kind
from drillrig_env.parameters import closest
from drillrig_env.plots.own_rig import differences
from drillrig_env.policy import policy_names
from drillrig_env.progress import Progress
from drillrig_env.rig import Rig
from drillrig_env.stability.stable_sets import critical_fall

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
  drillrig evaluate constant z_torque my_controller.py:MyPolicy

`seen` holds physical values by the channels' names, one entry a rig. A class that is no Baseline needs
Stable-Baselines3's predict(observation, state, episode_start, deterministic) on batches, and is made
without arguments.
"""


@command
def main(arguments: Sequence[str] | None = None, prog: str = "drillrig evaluate") -> int:
    """Parse the command line, put every policy through every suite, and report; the exit status."""
    parser = _parser(prog)
    chosen = parser.parse_args(arguments)
    line = shlex.join([*prog.split(), *(sys.argv[1:] if arguments is None else arguments)])
    try:
        if not chosen.no_pictures:
            importlib.import_module("drillrig_env.plots.style")  # a missing Matplotlib is found out before the work
        if chosen.saved:
            return _report_again(chosen)
        check_writable(chosen.output)
        posterior = None if chosen.calibration is None else Posterior.from_folder(chosen.calibration)
        kept = None if chosen.run is None else suite_of(chosen.run)
        if kept is not None and (chosen.rig is not None or chosen.judged_on is not None):
            raise ValueError("--run brings the rig of its run; give it without --rig and --judged-on")
        contestants, failures, conditions = find_contestants(
            chosen.policies,
            chosen.env or _env_of(chosen.suite or ()),
            chosen.slow,
            _warn,
            chosen.rig if kept is None else kept[0].rig,
            chosen.largest_reference,
            None if posterior is None else posterior.friction,
        )
        check_steady(conditions.rig)
        critical_fall(conditions.rig, "--rig")  # without one, no score could be told
        one_rig = posterior is not None or chosen.judged_on is not None
        asked = chosen.suite or (OF_ONE_RIG if one_rig else meant_for(conditions.env_id))
        suites = [suite(name, chosen.rigs, conditions.scales) for name in SUITES if name in asked]
        if kept is not None:
            suites = [kept[1]]
        elif (rigs := VerdictRigs.of(chosen.judged_on, posterior, conditions.rig, asked)) is not None:
            suites = [rigs.suite(one) for one in suites]
        _print(failures)
        names = [contestant.name for contestant in contestants]
        if chosen.rigs > LARGE:
            check_large()
        engine = engine_of(chosen)
        reference = chosen.reference or next(iter(names), "")
        if names and reference not in names:
            raise ValueError(
                f"--reference {reference} is not among the policies that compete; {closest(reference, names)}"
            )
    except (ValueError, ImportError, FileNotFoundError) as error:
        parser.error(error)
    if not contestants:
        return FAILED
    config = config_of(conditions, suites, contestants, drillrig_env.__version__, line, reference)
    if posterior:
        config["calibration"] = posterior.origin
    with owned(chosen.output):
        try:
            results, histories = begin(chosen.output, config, chosen.resume, chosen.overwrite, _warn)
        except ValueError as error:
            parser.error(error)
        with engine:
            failures += _run(suites, contestants, results, histories, chosen, engine)
            note_processors(results.provenance, engine.processors)
        if results.scores:
            results.estimates = all_estimates(results.scores, reference)
            save(chosen.output, results, histories)
            _draw(results, histories, chosen.output, chosen)
    for failure in failures:
        print(f"error: {failure}", file=sys.stderr)
    return FAILED if failures else DONE


def _env_of(suites: Sequence[str]) -> str | None:
    """The environment that all of some suites are meant for, where there is one."""
    meant = {suite(name).env_id for name in suites}
    return meant.pop() if len(meant) == 1 else None


def _parser(prog: str) -> Parser:
    parser = Parser(
        prog=prog,
        description=(__doc__ or "").replace("drillrig evaluate", prog),
        epilog=_EPILOG.replace("drillrig evaluate", prog),
    )
    add = parser.add_argument
    add("policies", nargs="*", help=f"who competes: {', '.join(policy_names())}, ...")
    add(
        "--env",
        choices=list(drillrig_env.ENVIRONMENTS),
        help="whose sensors (default: those that the named agents were trained with, or DrillRig-v0)",
    )
    add_rig_argument(parser)
    add(
        "--largest-reference",
        type=of_kind(POSITIVE, "rad/s"),
        metavar="RAD/S",
        help="upper end of the rig's speed reference; targets, forces and friction go with it (default: by its period)",
    )
    add(
        "--judged-on",
        metavar="FILE",
        help="the rig that turns, where it is not that of --rig, which policies are designed for: a file with the "
        "tables [rig] and [friction], whose N_1 is the largest that is drawn; the drive is set as on --rig",
    )
    add("--slow", action="store_true", help="without names, let slow policies (mppi) in as well")
    add(
        "--suite",
        nargs="+",
        choices=list(SUITES),
        help=f"default: those of the environment's own rigs where it has such, or {' '.join(OF_ONE_RIG)}",
    )
    add(
        "--rigs",
        type=of_kind(COUNT),
        default=1000,
        help="random rigs of a suite that is drawn (default: 1000, 256 rigs with 16 draws each of a fleet)",
    )
    add("--output", type=Path, default=Path("results"), help="folder for the results (default: results)")
    add("--run", type=Path, metavar="FILE", help="in place of suites: the rig of a run that `drillrig room` has kept")
    kept = parser.add_mutually_exclusive_group()
    kept.add_argument("--resume", action="store_true", help="go on with the results in the output folder")
    kept.add_argument("--overwrite", action="store_true", help="replace whatever results are in the output folder")
    add("--reference", metavar="NAME", help="policy that the others are compared with (default: the first)")
    add_engine_arguments(parser, f"pieces of {PIECE:,} rigs", "1, whose kernels have all cores")
    add("--details", action="store_true", help="print also hardness, other scores and paired differences")
    add("--no-pictures", action="store_true", help="draw nothing")
    add("--from", dest="saved", type=Path, metavar="DIR", help="report the results of a folder; run nothing")
    return parser


def _report_again(chosen: argparse.Namespace) -> int:
    """The tables and pictures of results that are there."""
    results = read(chosen.saved)
    try:
        histories = Histories() if chosen.no_pictures else read_histories(chosen.saved)
    except ValueError as error:
        _warn(f"no pictures over time: {error}")
        histories = Histories()
    for name in results.scores:
        _report(results, name, chosen.reference or results.config["reference"], chosen)
    _draw(results, histories, chosen.saved, chosen)
    return DONE


def _run(
    suites: Sequence[Suite],
    contestants: Sequence[Contestant],
    results: Results,
    histories: Histories,
    chosen: argparse.Namespace,
    engine: Engine,
) -> list[Failure]:
    """Run what is not there yet, suite by suite, with a table after each; who failed."""
    failures = []
    if any(not results.has(one.name, contestant.name) for one in suites for contestant in contestants):
        clear_pictures(chosen.output)
    try:
        for one in suites:
            left = [contestant for contestant in contestants if not results.has(one.name, contestant.name)]
            with Progress(one.name, len(left)) as progress:
                failed = run_contest(one, left, results, histories, chosen.output, progress.show, engine)
            _print(failed)
            failures += failed
            if one.name in results.scores:
                _report(results, one.name, chosen.reference or results.config["reference"], chosen)
    except KeyboardInterrupt as stop:
        line = results.config["command"].replace(" --overwrite", "")
        again = line if chosen.resume else f"{line} --resume"
        stop.add_note(f"what was finished is in {chosen.output}; to go on: {again}")
        raise
    return failures


def _report(results: Results, name: str, reference: str, chosen: argparse.Namespace) -> None:
    about = results.config["suites"][name]
    counted = "episodes" if "rigs" in about["scenario"] else "rigs"
    title = f"{name}: {about['description']} ({about['rigs']} {counted}, {results.config['env']})"
    changed = differences(Rig.of(results.config.get("rig")))
    if changed and "rigs" not in about["scenario"]:
        title += f", each with {changed}"
    print_suite(title, results.scores[name], results.marks, reference, chosen.details, bool(chosen.reference))


def _draw(results: Results, histories: Histories, folder: Path, chosen: argparse.Namespace) -> None:
    if not chosen.no_pictures:
        from drillrig_env.evaluation.pictures import draw_all

        draw_all(results, histories, folder)
    print(f"results.csv, results.json{'' if chosen.no_pictures else ', pictures'}: {folder.resolve()}")


def _print(failures: Sequence[Failure]) -> None:
    """Failures as they happen, each with the innermost calls of its traceback."""
    for failure in failures:
        _warn(f"error: {failure}\n{failure.trace}".rstrip())


def _warn(line: str) -> None:
    print(line, file=sys.stderr)
