"""Training: steps a second, seconds until nine rigs in ten are mitigated, and where the time goes.

    python -m benchmarks.training --quick                            # speeds alone: about three minutes
    python -m benchmarks.training                                    # until both reach 0.9: about a quarter of an hour
    python -m benchmarks.training --algorithms ppo --seeds 9 --cores 1

PPO and SAC are trained on `DrillRig-v0` as `train.py` does it, by the same function with the hyperparameters of
the softened drive, TensorBoard log and checkpoints, and stop where 0.9 of 200 rigs are first seen mitigated. These
are rigs of the evaluation during training: neither trained nor judged on. For comparison the same algorithm, with
the same settings and as many environments, learns Gymnasium's Pendulum-v1 from SB3's `make_vec_env`
(`DummyVecEnv`); of that only the speed counts.

Each run has a fresh process that is held on its cores (`os.sched_setaffinity`). The rigs may be stepped on
all of these, where that many are worth a thread; PyTorch and BLAS have one thread (`torch.set_num_threads`,
OMP_NUM_THREADS), as `train.py` has it. One run more on several cores gives them all to PyTorch.

Steps a second: the median over chunks of some rollouts with their updates, of all seeds, after the first update.
Shares of time: of the same chunks; `benchmarks/shares.py` says what counts for which. Seconds and steps to 0.9: the
median over the seeds, from the first reset on, with SAC's random steps; where rigs are validated more often 0.9 is
seen earlier. Start-up, compilation and validation are not in them; the file has them apart.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.measure import kept, note, print_table, write_json
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.extras import missing
from drillrig_env.flags import of_kind
from drillrig_env.jit.threads import available_threads
from drillrig_env.parameters import refuse

try:
    from benchmarks.one_training import GOAL, RIG, RIGS, Run, check_cores, in_fresh_process
    from benchmarks.shares import PARTS
except ImportError as error:
    raise missing("training", "Stable-Baselines3", "agents") from error

PENDULUM = "Pendulum-v1"
SEEDS = {"ppo": 5, "sac": 3}
CHUNK_STEPS = {  # a chunk of PPO's holds as many rollouts as it takes until all episodes have ended once
    ("ppo", RIG): 81_920,
    ("ppo", PENDULUM): 32_768,
    ("sac", RIG): 1_024,
    ("sac", PENDULUM): 1_024,
}
VALIDATE_EVERY = {"ppo": 16_384, "sac": 1_024}  # steps
SETTING = ("algorithm", "environment", "cores", "torch_threads")
"""What runs of different seeds share."""
HEADINGS = (
    *("algorithm", "environment", "cores", "PyTorch threads", "steps/s", "s to 0.9", "steps to 0.9"),
    *("env %", "policy %", "update %", "other %", "steps/s, env alone"),
)


def plan(
    algorithms: Sequence[str], cores: Sequence[int], seeds: int | None, chunks: int = 5, quick: bool = False
) -> list[Run]:
    """The runs in their order: `seeds` of each setting, `chunks` timed in each. `ValueError` for less than one.

    The peer has its turn after each seed, so that both meet the same machine.
    """
    for name, value in (("seeds", seeds), ("repeats", chunks)):
        if value is not None and value < 1:
            raise refuse("training", name, value, "", ">= 1")
    runs = []
    for algorithm in algorithms:
        every = None if quick else VALIDATE_EVERY[algorithm]
        chunk, peer_chunk = CHUNK_STEPS[algorithm, RIG], CHUNK_STEPS[algorithm, PENDULUM]
        for number in cores:
            for seed in range(seeds or (1 if quick else SEEDS[algorithm])):
                runs.append(Run(algorithm, RIG, number, 1, seed, chunk, chunks, every))
                runs.append(Run(algorithm, PENDULUM, number, 1, seed, peer_chunk, chunks))
        runs += [Run(algorithm, RIG, number, number, 0, chunk, chunks) for number in cores if number > 1]
    return runs


def summary(runs: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """A row for each setting, with its seeds together; what was not asked for or not reached is None."""
    settings: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for run in runs:
        settings.setdefault(tuple(run[name] for name in SETTING), []).append(run)
    return [
        {**dict(zip(SETTING, setting, strict=True)), "n_envs": group[0]["n_envs"], **_speed(group), **_goal(group)}
        for setting, group in settings.items()
    ]


def _speed(runs: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Steps a second, the median over the chunks of all runs, and shares of their time in percent."""
    chunks = {name: [value for run in runs for value in run["chunks"][name]] for name in ("steps", "seconds", *PARTS)}
    speeds = [steps / seconds for steps, seconds in zip(chunks["steps"], chunks["seconds"], strict=True)]
    total = {name: sum(values) for name, values in chunks.items()}
    shares = {name: 100.0 * total[name] / total["seconds"] for name in PARTS}
    return {
        "chunks": len(speeds),
        "steps_per_second": statistics.median(speeds),
        **{f"{name}_percent": share for name, share in shares.items()},
        "other_percent": 100.0 - sum(shares.values()),
        "env_steps_per_second": total["steps"] / total["env"],
    }


def _goal(runs: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Median steps and seconds to the goal, where a run that did not reach it took infinitely long."""
    asked = [run for run in runs if run["validate_every"]]
    reached = [run["reached"] for run in asked if run["reached"]]
    never = [{"steps": math.inf, "seconds": math.inf}] * (len(asked) - len(reached))
    medians = {
        name: statistics.median([one[name] for one in reached + never]) if asked else math.inf
        for name in ("steps", "seconds")
    }
    return {
        "runs_to_goal": len(asked),
        "runs_that_reached_it": len(reached),
        **{f"{name}_to_goal": value if math.isfinite(value) else None for name, value in medians.items()},
    }


def cells(row: dict[str, Any]) -> list[str]:
    """A row of the printed table."""
    absent = "not reached" if row["runs_to_goal"] else "-"
    goal = [
        absent if row[name] is None else format(row[name], digits)
        for name, digits in (("seconds_to_goal", ".1f"), ("steps_to_goal", ",.0f"))
    ]
    shares = [f"{row[f'{name}_percent']:.0f}" for name in (*PARTS, "other")]
    setting = [str(row[name]) for name in SETTING]
    return [*setting, f"{row['steps_per_second']:,.0f}", *goal, *shares, f"{row['env_steps_per_second']:,.0f}"]


def told(run: dict[str, Any]) -> str:
    """A finished run in a line."""
    speed = _speed([run])
    where = f"{run['algorithm']} on {run['environment']}, {run['cores']} core(s), {run['torch_threads']} for PyTorch"
    reached = run["reached"]
    goal = f"; 0.9 after {reached['seconds']:.1f} s, {reached['steps']:,} steps" if reached else ""
    return f"{where}, seed {run['seed']}: {speed['steps_per_second']:,.0f} steps/s{goal}"


def results(runs: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """What the file holds: the table's rows, and every run with its chunks."""
    return {"goal": GOAL, "validation_rigs": RIGS, "rows": summary(runs), "runs": list(runs)}


@command
def main() -> None:
    """Train, and print and write the table."""
    parser = Parser(prog="python -m benchmarks.training", description=__doc__)
    add = parser.add_argument
    add("--algorithms", nargs="+", choices=list(SEEDS), default=list(SEEDS), help="which (default: both)")
    there = [number for number in (1, 2) if number <= available_threads()]
    add(
        "--cores",
        nargs="+",
        type=of_kind(COUNT),
        default=there,
        help="numbers of cores (default: 1 2, as far as there are)",
    )
    add("--seeds", type=of_kind(COUNT), help="training seeds 0, 1, ... of each algorithm (default: 5 of ppo, 3 of sac)")
    add("--repeats", type=of_kind(COUNT), default=5, help="chunks that are timed in each run, at least (default: 5)")
    add("--quick", action="store_true", help="speeds and shares alone, of one seed")
    add("--json", type=Path, default=Path("results/benchmarks/training.json"), help="file to write")
    arguments = parser.parse_args()
    try:
        for cores in arguments.cores:
            check_cores(cores)
        left = plan(arguments.algorithms, arguments.cores, arguments.seeds, arguments.repeats, arguments.quick)
    except ValueError as error:
        parser.error(error)
    runs: list[dict[str, Any]] = []

    def tell() -> None:
        if runs:
            print_table(HEADINGS, [cells(row) for row in summary(runs)])
            write_json(arguments.json, results(runs))

    with kept(arguments.json, tell):
        for number, run in enumerate(left, 1):
            try:
                runs.append(in_fresh_process(run))
            except RuntimeError as error:
                note(f"[{number}/{len(left)}] {run.algorithm} on {run.environment} failed: {error}")
                continue
            note(f"[{number}/{len(left)}] {told(runs[-1])}")
            write_json(arguments.json, results(runs), announce=False)


if __name__ == "__main__":
    raise SystemExit(main())
