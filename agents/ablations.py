"""Train variants of the shipped PPO setting, score them, and write what each choice is worth.

    python -m agents.ablations                                   # everything that is not done yet
    python -m agents.ablations --variants shipped stiff_drive    # some of it
    python -m agents.ablations --steps 20000 --seeds 2 --rigs 50 --output /tmp/quick.json

Every variant is trained with the same seeds and steps and scored on the same rigs of the training side,
from developed stick-slip (`agents.training.validation_rigs`): the rigs of the suites stay unseen. The cost is that of
the environment's default reward for all. The file is written after each training; a training that it
holds already is not repeated, unless the setting has changed since.
"""

from __future__ import annotations

import json
import shlex
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from rich.console import Console
from stable_baselines3.common.callbacks import BaseCallback

from agents.policy.absolute_action import AbsoluteAction, AbsoluteAgent
from agents.policy.agent import Agent
from agents.policy.environment import make_environment
from agents.training.hyperparameters import algorithm_arguments, algorithm_class
from agents.training.progress import bars
from agents.training.settings import checked_config
from agents.variants import VARIANTS, Variant
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import default_suite
from drillrig_env.files import check_writable_file, write_text
from drillrig_env.flags import of_kind
from drillrig_env.parameters import refuse
from drillrig_env.seeds import VALIDATION_SEEDS

COMMAND = "python -m agents.ablations"
FILE = Path("docs/agents/ablations.json")
STEPS, SEEDS, RIGS = 1_500_000, 3, 1000

_MADE_BY = ("algorithm", "env_id", "env_kwargs", "hyperparameters")
"""Entries of a training's config that must agree for it to count as done."""


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Parse the command line, train what is missing, and write the file."""
    names = [variant.name for variant in VARIANTS]
    parser = Parser(prog=COMMAND, description=__doc__)
    parser.add_argument("--variants", nargs="+", choices=names, default=names, help="which (default: all)")
    parser.add_argument("--steps", type=of_kind(COUNT), default=STEPS, help=f"of each training (default: {STEPS})")
    parser.add_argument("--seeds", type=of_kind(COUNT), default=SEEDS, help=f"of each variant (default: {SEEDS})")
    parser.add_argument("--rigs", type=of_kind(COUNT), default=RIGS, help=f"that each is scored on (default: {RIGS})")
    parser.add_argument("--threads", type=of_kind(COUNT), help="threads that step the rigs (default: all cores)")
    parser.add_argument("--output", type=Path, default=FILE, help=f"file to write (default: {FILE})")
    chosen = parser.parse_args(arguments)
    line = shlex.join([*COMMAND.split(), *(sys.argv[1:] if arguments is None else arguments)])
    check_writable_file(chosen.output)
    variants = [variant for variant in VARIANTS if variant.name in chosen.variants]
    try:
        ablate(variants, chosen.seeds, chosen.steps, chosen.rigs, chosen.output, threads=chosen.threads, command=line)
    except ValueError as error:
        parser.error(str(error))
    except KeyboardInterrupt as stop:
        stop.add_note(f"what was finished is in {chosen.output}; to go on: {line}")
        raise
    print(chosen.output.resolve())


def ablate(
    variants: Sequence[Variant],
    seeds: int,
    steps: int,
    rigs: int,
    output: Path,
    *,
    changes: Mapping[str, Any] | None = None,
    threads: int | None = None,
    command: str = COMMAND,
) -> dict[str, Any]:
    """Train and score what `output` does not hold yet, write it there after each training, and return it all.

    `changes` are hyperparameters that every variant gets. `ValueError` for numbers below 1 and for settings
    that a training refuses, before anything is trained.
    """
    for name, value in (("seeds", seeds), ("steps", steps), ("rigs", rigs)):
        if value < 1:
            raise refuse("ablations", name, value, "", ">= 1")
    configs = {
        (variant.name, str(seed)): checked_config(variant.training(seed, steps, changes))
        for variant in variants
        for seed in range(seeds)
    }
    content = json.loads(output.read_text(encoding="utf-8")) if output.is_file() else {}
    found: dict[str, Any] = content.get("variants", {})
    left = [(variant, str(seed)) for variant in variants for seed in range(seeds)]
    for number, (variant, seed) in enumerate(left, 1):
        config = json.loads(json.dumps(configs[variant.name, seed]))
        about = {"words": variant.words, "rigs": rigs, "absolute_action": variant.absolute_action}
        about |= {name: config[name] for name in _MADE_BY}
        entry = found.get(variant.name, {})
        if {name: value for name, value in entry.items() if name != "runs"} != about:
            entry = found[variant.name] = {**about, "runs": {}}
        label = f"{number}/{len(left)} {variant.name}, seed {seed}"
        if seed in entry["runs"]:
            print(f"{label}: done before", flush=True)
            continue
        begun = time.monotonic()
        agent = _train(variant, configs[variant.name, seed], threads, label)
        seconds = time.monotonic() - begun
        entry["runs"][seed] = {"seconds": round(seconds, 1), "scores": evaluate(agent, rigs, threads)}
        entry["runs"] = {key: entry["runs"][key] for key in sorted(entry["runs"], key=int)}
        found = {one.name: found[one.name] for one in VARIANTS if one.name in found} | found
        content = {"command": command, "provenance": provenance(), "variants": found}
        write_text(output, json.dumps(content, indent=1, ensure_ascii=False) + "\n")
        scores = entry["runs"][seed]["scores"]
        shown = ", ".join(f"{name} {value:.3f}" for name, value in scores.items() if value is not None)
        print(f"{label}: {shown}; trained in {seconds:.0f} s", flush=True)
    return content


def evaluate(agent: Agent, rigs: int, threads: int | None = None) -> dict[str, float | None]:
    """Mitigated share of all rigs, of those below the critical speed and of the others; time to calm (s); cost.

    None where there is no such rig.
    """
    suite = replace(default_suite(rigs), name="validation", first_seed=VALIDATION_SEEDS.start)
    shown = {name: agent.environment[name] for name in ("noise", "delay") if name in agent.environment}
    policy = agent.at_slew_limit(suite.slew_limit)
    scores = score(run(policy, suite, sensors=agent.environment["sensors"], threads=threads, **shown))
    below = scores["region"] == "below"
    return {
        "mitigated": float(scores["mitigated"].mean()),
        "below": _share(scores["mitigated"][below]),
        "above": _share(scores["mitigated"][~below]),
        "time_to_calm": float(np.median(np.asarray(scores["time_to_calm"], dtype=float))),
        "cost": float(scores["cost"].mean()),
    }


def _share(outcomes: np.ndarray) -> float | None:
    return float(outcomes.mean()) if len(outcomes) else None


def _train(variant: Variant, config: Mapping[str, Any], threads: int | None, label: str) -> Agent:
    """Train one seed of a variant as `train.py` does, but for files, checkpoints and evaluations on the way."""
    torch.set_num_threads(1)
    chosen = config["hyperparameters"]
    env_kwargs = {**config["env_kwargs"], "threads": threads}
    frames = chosen.get("frame_stack", 1)
    env = make_environment(config["env_id"], chosen["n_envs"], config["seed"], env_kwargs, frames)
    if variant.absolute_action:
        env = AbsoluteAction(env)
    arguments = algorithm_arguments(chosen)
    model = algorithm_class(config["algorithm"])(env=env, seed=config["seed"], device="cpu", **arguments)
    if Console().is_terminal:
        with bars() as shown:
            task = shown.add_task(label, total=chosen["n_timesteps"], numbers={})
            show = _Show(lambda steps: shown.update(task, completed=steps, numbers={"steps": steps}))
            model.learn(chosen["n_timesteps"], callback=show)
    else:
        model.learn(chosen["n_timesteps"])
    return (AbsoluteAgent if variant.absolute_action else Agent)(model, config)


class _Show(BaseCallback):
    """Tell how many steps are done, once a rollout."""

    def __init__(self, tell: Callable[[int], object]) -> None:
        super().__init__()
        self.tell = tell

    def _on_rollout_end(self) -> None:
        self.tell(self.num_timesteps)

    def _on_step(self) -> bool:
        return True


if __name__ == "__main__":
    raise SystemExit(main())
