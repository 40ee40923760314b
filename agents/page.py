"""Write docs/agents.md and its pictures: what ships, how it learnt, what it does, and what each choice is worth.

    python -m agents.page           # from agents/trained, docs/agents and docs/results
    python -m agents.page --check   # only say whether the page is up to date

The numbers come from `agents.shipping.ship` (agents/trained/*/seeds.json), `agents.compare`
(docs/agents/ablations.json and newcomer.json, if they are there) and the stored results of `eval.py` (docs/results, if
they are there); what a person saw in the pictures is quoted from docs/agents/findings.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from agents.beside_lqg import results_with_both, section
from agents.choices import choices, made, newcomers
from agents.pictures.learning import action_zero, learning_curves
from agents.policy.run_folder import TRAINED, read_config, read_seeds
from agents.rivals import ahead, beside
from agents.shipping.card import imitation_steps, training_minutes
from agents.shipping.export import EXAMPLE
from drillrig_env import markdown
from drillrig_env.command_line import Failed, Parser, command
from drillrig_env.evaluation.provenance import when_and_where
from drillrig_env.evaluation.report import markdown_table
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.statistics import interquartile_mean
from drillrig_env.evaluation.tables import MAIN, OTHERS, Table, stored_row
from drillrig_env.files import check_writable, write_text

COMMAND = "python -m agents.page"
AGENT = "ppo"
"""The agent whose behaviour is shown."""

_SHOWN = Table((*MAIN.columns, OTHERS.columns[0]), f"{MAIN.caption}; cost: mean of - reward")
_PLAIN = "**On the rig's own drive**, the environment as `gym.make` gives it:\n"
_SOFT = (
    "**Where the drive is ours to change.** Softened gains, those of `soft_torque`, free most rigs without any "
    "agent; what an agent adds is small, and on the rig's own drive these agents do not work:\n"
)
_BESIDE = {
    False: (
        ("constant", "DrillRig-v0", "action 0, same drive (`constant`)"),
        ("lqg", "DrillRig-v0", "`lqg`, same drive and sensors"),
        ("lqg", "DrillRigSurface-v0", "`lqg`, sensors of the surface"),
    ),
    True: (("soft_torque", "DrillRig-v0", "action 0, same drive (`soft_torque`)"),),
}
"""What stands beside the agents, by whether the drive is softened: a policy, its environment, what it is called."""

_LEVELS = (0.5, 0.9, 0.95)

_USE = f"""## Train, resume, export

```sh
python train.py ppo --seeds 5 --run-folder runs/ppo  # five seeds, one after another; --jobs 2: two at a time
python train.py --resume runs/ppo                    # go on after Ctrl-C, bit for bit as without the stop
python -m agents.shipping.ship runs/ppo --name ppo   # evaluate all seeds, ship the median one, write its card
python -m agents.compare ablations                   # the table of choices above
python -m agents.page                                # this page
python train.py ppo --conf-file agents/hyperparams/soft_drive/ppo.yml  # an agent for the softened drive
```

`python train.py --help` lists the rest: hyperparameters and arguments of the environment can be changed on the
command line, and an unknown one is refused with the closest known name. A run's folder holds its config, command,
versions, evaluations and models.

Nothing that was learnt is lost: a checkpoint stays until the last model is whole, every file is whole or not there,
one process at a time trains in a folder, and a damaged file is named in one sentence. `train.py` ends with 0 (done),
1 (failed), 2 (the arguments are not allowed), 130 (stopped by Ctrl-C) or 143 (by SIGTERM).

**Models of other people.** Stable-Baselines3 keeps settings in `model.zip` as pickles, and `PPO.load` runs whatever
code their maker put there. This project reads a run's settings from `config.json` and only tensors from
`model.zip`: `eval.py` and the export execute nothing that a run folder holds. `train.py --resume` does load the
checkpoint's pickles: go on with your own trainings only. To pass an agent on, use ONNX, which holds no code.

`python train.py --resume-from ppo` goes on from a shipped agent with its settings and a rate that begins anew;
`agents.training.fine_tuning.load_trainable("ppo", env)` gives its model for a loop of your own.

**In Stable-Baselines3 alone** an agent is a plain model. Its frames are SB3's own, oldest first, and its actions are
bit for bit those of `drillrig_env.policy.load("ppo")`:

```python
import drillrig_env
from stable_baselines3 import PPO
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import VecFrameStack

env = VecFrameStack(drillrig_env.make_sb3(16, seed=0), n_stack=8)
model = PPO.load("agents/trained/ppo/model.zip", env=env, device="cpu")
print(evaluate_policy(model, env, n_eval_episodes=16))  # mean and spread of the returns
```

Another agent needs its own environment, frames and slew limit: with `agent = load("ppo_robust")` it is
`VecFrameStack(make_sb3(16, env_id=agent.env_id, **agent.env_kwargs, slew_limit=agent.slew_limit), agent.frames)`, since
a model's action is a share of the slew limit that it was trained with, which the contract's agent takes care of.

**In rl-zoo3** the hyperparameter files train as they are where nothing is imitated first: those for the rig's own drive
in `agents/hyperparams/alone`, those for the softened one in `agents/hyperparams/soft_drive`, each for PPO and SAC.
`train.py` takes the same files.

```sh
python train.py ppo --conf-file agents/hyperparams/alone/ppo.yml
cd agents/hyperparams/alone
python -m rl_zoo3.train --gym-packages drillrig_env --env DrillRig-v0 --algo ppo -conf ppo.yml
```

rl-zoo3 steps single environments one by one, where `train.py` steps all rigs in one compiled call. The keys
`imitation`, `anchor`, `critic_iterations` and `staggered` are this project's own: rl-zoo3 hands them to the algorithm,
which refuses them (`unexpected keyword argument 'imitation'`). So `ppo.yml`, `ppo_robust.yml` and `sac.yml` in
`agents/hyperparams`, which imitate first, are for `train.py` alone. Those in `alone` were tried with rl_zoo3 2.9.2 for
98,304 steps (PPO) and 12,000 steps (SAC), 17 s of computing each, not to the end.

`python -m agents.shipping.export ppo --out policy.onnx` writes an agent as one file that takes measured values in
physical units by name and gives the rate of the speed reference in rad/s², with scaling, clipping and slew limit
inside. It plays recorded episodes through both and fails where they differ by more than 1e-5 rad/s². This runs it,
with nothing but onnxruntime and NumPy:

```text
{EXAMPLE.strip()}
```
"""


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Draw the pictures and write the page, or only check it."""
    parser = Parser(prog=COMMAND, description=__doc__)
    parser.add_argument("--docs", type=Path, default=Path("docs"), help="folder of the documentation (default: docs)")
    parser.add_argument("--check", action="store_true", help="write nothing; fail where the page is out of date")
    chosen = parser.parse_args(arguments)
    path = chosen.docs / "agents.md"
    if not chosen.check:
        check_writable(chosen.docs)
    try:
        text = page(chosen.docs)
    except ValueError as error:
        parser.error(str(error))
    if chosen.check:
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            raise Failed(f"{path} is out of date; run: {COMMAND}")
        return
    from agents.pictures import draw_all

    draw_all(AGENT, chosen.docs / "images" / "agents", results=_beside_lqg(chosen.docs))
    write_text(path, text)
    print(path.resolve())


def page(docs: Path, trained: Path = TRAINED) -> str:
    """The page as Markdown. `ValueError` where the agent that it shows is not shipped."""
    found = {path.name: seeds for path in sorted(trained.glob("*")) if (seeds := read_seeds(path)) is not None}
    if AGENT not in found:
        raise ValueError(
            f"{trained} holds no agent {AGENT!r} with its seeds.json; make it with: python -m agents.shipping.ship"
        )
    parts = [_shipped(found, trained, docs), _learning(found, trained), _behaviour(docs)]
    parts += [section(_beside_lqg(docs, trained)), choices(docs), newcomers(docs)]
    parts += [ahead(docs, {name: read_config(trained / name)["env_id"] for name in found}), _USE, _made(docs, found)]
    return "\n".join(part for part in parts if part)


def _shipped(found: Mapping[str, Mapping[str, Any]], trained: Path, docs: Path) -> str:
    """What ships and what it scores, on the rig's own drive and on the softened one, beside action 0 and a rival."""
    parts = [
        "# The agents\n",
        "The agents learn on random rigs to move the drive's speed reference so that stick-slip ends and the bit turns "
        "calmly at the target. They are told neither the normal force nor the friction. The names below work wherever "
        'a policy is asked for, as in `python eval.py ppo`, and `drillrig_env.policy.load("ppo")` brings one with '
        "the environment that it belongs in.\n",
        f"On {next(iter(found.values()))['rigs']['default']:,} held-out rigs of the suite `default`, interquartile "
        "mean over all training seeds with its 95 % bootstrap interval; of what is not trained, with that over rigs.\n",
    ]
    for soft, words in ((False, _PLAIN), (True, _SOFT)):
        rows = {
            f"[`{name}`](../agents/trained/{name}/README.md)": stored_row(
                {**seeds["pooled"]["default"]["main"], **seeds["pooled"]["default"]["others"]}
            )
            for name, seeds in found.items()
            if _is_soft(trained, name) is soft
        }
        if rows:
            rows |= beside(docs, _BESIDE[soft])
            parts += [words, markdown_table(_SHOWN, rows, {}, "policy"), ""]
    about = []
    for name, seeds in found.items():
        config = read_config(trained / name)
        steps, minutes = f"{config['hyperparameters']['n_timesteps']:,}", training_minutes(seeds)
        imitated = imitation_steps(config)
        about.append(
            (
                f"`{name}`",
                f"`{config['env_id']}`",
                config["algorithm"],
                f"{imitated:,}" if imitated else "none",
                steps,
                minutes,
                len(seeds["seeds"]),
            )
        )
    headings = ("agent", "environment", "algorithm", "steps of imitation", "of trial", "training, min a seed", "seeds")
    return "\n".join(
        [
            *parts,
            f"*{markdown.sentence(_SHOWN.caption)}*\n",
            markdown.table(headings, about, 3),
            "\nHeld calm at the target by the seed that ships, left to itself for longer than the suites' 60 s:\n",
            _endurance(found, trained),
            "\nThe seed that ships is the one of median mitigated share, not the best one. Each agent's card has its "
            "scores in all suites, seed by seed, and where it fails.\n",
        ]
    )


def _is_soft(trained: Path, name: str) -> bool:
    """Whether an agent works through a softened drive."""
    return bool(read_config(trained / name)["env_kwargs"].get("drive"))


def _endurance(found: Mapping[str, Mapping[str, Any]], trained: Path) -> str:
    """How long each agent holds what it reached, as a table."""
    times = list(next(iter(found.values()))["endurance"])
    rows = [[f"`{name}`", *(f"{seeds['endurance'][time]:.3f}" for time in times)] for name, seeds in found.items()]
    for soft, words in ((False, "action 0, the rig's own drive"), (True, "action 0, softened drive")):
        of_drive = [one["action_zero"]["endurance"] for name, one in found.items() if _is_soft(trained, name) is soft]
        rows += [[words, *(f"{held[time]:.3f}" for time in times)] for held in of_drive[:1]]
    return markdown.table(["agent", *(f"{time} s" for time in times)], rows)


def _learning(found: Mapping[str, Mapping[str, Any]], trained: Path) -> str:
    """The learning curves, and when they pass what."""
    lines = [
        "## How they learn\n",
        "![Share of rigs mitigated over training steps, every seed](images/agents/learning.png)\n",
    ]
    headings = [
        "agent",
        *(f"steps to {level:g}" for level in _LEVELS),
        "at the end, lowest to highest seed",
        "action 0",
    ]
    rows = []
    for name, seeds in found.items():
        steps, shares = learning_curves(seeds)
        curve = interquartile_mean(shares, axis=0)
        passed = [
            f"{steps[np.argmax(curve >= level)]:,.0f}" if (curve >= level).any() else "never" for level in _LEVELS
        ]
        ends = f"{shares[:, -1].min():.3f} to {shares[:, -1].max():.3f}"
        rows.append([f"`{name}`", *passed, ends, f"{action_zero(read_config(trained / name)):.3f}"])
    lines.append(markdown.table(headings, rows))
    lines.append(
        "\n*Steps after which the interquartile mean over the seeds first reaches a mitigated share, as far as the "
        "evaluations during training resolve it; these rigs are not those of the suites. Action 0: the reference "
        "stays at the target, on the same drive and rigs.*\n"
    )
    return "\n".join(lines)


def _behaviour(docs: Path) -> str:
    """The pictures of behaviour and what a person saw in them."""
    words = docs / "agents" / "findings.md"
    seen = words.read_text(encoding="utf-8").strip() + "\n" if words.is_file() else ""
    return "\n".join(
        [
            f"## What `{AGENT}` does\n",
            "![One rig over time under three rivals and the agent, from the same start](images/agents/histories.png)\n",
            "![The agent's action over twist and bit speed, beside the torque law's](images/agents/plane.png)\n",
            seen,
        ]
    )


def _beside_lqg(docs: Path, trained: Path = TRAINED) -> dict[str, Results]:
    """The stored results of every agent for the rig's own drive, where they hold LQG too."""
    names = [path.name for path in sorted(trained.glob("*")) if read_seeds(path) is not None]
    plain = [name for name in names if not _is_soft(trained, name)]
    return results_with_both(docs, {name: read_config(trained / name)["env_id"] for name in plain})


def _made(docs: Path, found: Mapping[str, Mapping[str, Any]]) -> str:
    """Commands, dates and machines behind the numbers."""
    lines = [f"## How it was made\n\nThis page and its pictures come from stored numbers with `{COMMAND}`.\n"]
    lines += [
        f"- `{name}`: `{seeds['command']}`, {when_and_where(seeds['provenance'])}" for name, seeds in found.items()
    ]
    lines += made(docs)
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    raise SystemExit(main())
