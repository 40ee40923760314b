"""The model cards of the shipped agents, from what `agents.shipping.ship` left beside them."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from agents.policy.action_zero import SAME_DRIVE
from agents.policy.agent import Agent
from agents.policy.environment import environment_arguments
from agents.policy.run_folder import MODEL, TRAINED, load_policy, read_config, read_seeds, seeds_of, shipped
from drillrig_env import markdown
from drillrig_env.drive import Drive
from drillrig_env.env.scenario import STICK_SLIP
from drillrig_env.env.task import Task
from drillrig_env.evaluation.report import markdown_table
from drillrig_env.evaluation.suites import OF_ONE_RIG, home_suite, suite
from drillrig_env.evaluation.tables import HARDNESS, MAIN, OTHERS, TABLES, Row, Table, stored_row
from drillrig_env.files import write_text
from drillrig_env.verdict import CALM_INDEX

CARD = "README.md"

SHARED_DRAWS = (
    "Environment i of training seed s draws with the seed s + i: seeds s and s + 1 meet the same rigs in all but one "
    "environment and differ by first weights and exploration, so that the spread over seeds is likely too narrow."
)
"""What a reader must know of intervals over training seeds."""

_COUNTED = {"rigs": "rigs", "not mitigated": "failed", "of these calm, off the target": "calm"}
"""What the card counts by hardness, and what `seeds.json` calls it."""

EXAMPLE = """\
from drillrig_env.policy import load

agent = load("NAME")
env = agent.make_env()
observation, info = env.reset(seed=SEED, options={"start": "stick_slip"})
memory, over = None, False
while not over:
    action, memory = agent.predict(observation, memory)
    observation, reward, terminated, over, info = env.step(action)
print(info["is_success"])  # whether the last 10 s were calm and at the target
"""
"""How to load and run an agent of the name NAME, on the rig of a SEED."""


def _verdict(env_id: str) -> str:
    """What to know of the example's last line: a rig on a tilted disc is judged otherwise in its suite."""
    own = suite(home_suite(env_id), 1).calm_index
    if own == CALM_INDEX:
        return ""
    return (
        f"There calm is a stick-slip index below {CALM_INDEX:g}, which such a rig hardly ever has; the scores above "
        f"count it as calm below {own:g}, where the bit is certain not to stop.\n\n"
    )


def write_card(name: str, trained: Path = TRAINED) -> Path:
    """Write one agent's card and return its path. `ValueError` where the agent or its `seeds.json` is missing."""
    path = trained / name / CARD
    text = card(name, trained)
    write_text(path, text)
    return path


def card(name: str, trained: Path = TRAINED) -> str:
    """The card of a shipped agent as Markdown. `ValueError` where the agent or its `seeds.json` is missing."""
    folder = trained / name
    seeds = seeds_of(folder)
    config = read_config(folder)
    home = home_suite(config["env_id"])
    parts = [_task(name, config), _scores(seeds, home), _failures(seeds, home), _use(name, load_policy(folder))]
    parts += [_training(config, seeds), *_beside(name, trained), "## Licence\n\nMIT, as the rest of the package.\n"]
    return "\n".join(parts)


def tables_of_card(tables: Mapping[str, Any], at_home: bool) -> dict[str, Any]:
    """Of an agent's tables in a suite those that its card shows: the headline, and all where it is at home."""
    return {name: tables[name] for name in (TABLES if at_home else ("main",))}


def training_minutes(seeds: Mapping[str, Any]) -> str:
    """The median wall time of the seeds' trainings in minutes, as text; also where one is not known."""
    times = [one["seconds"] for one in seeds["seeds"].values()]
    return _minutes(float(np.median(times)) if all(times) else None)


def imitation_steps(config: Mapping[str, Any]) -> int:
    """How many steps of an environment an agent imitated before it learnt by trial; 0 where it did not."""
    how = config["hyperparameters"].get("imitation")
    if not how:
        return 0
    task = Task.of(**environment_arguments(config["env_id"], config["env_kwargs"]))
    return int(how["rounds"] * task.steps * config["hyperparameters"]["n_envs"])


def _task(name: str, config: Mapping[str, Any]) -> str:
    arguments = environment_arguments(config["env_id"], config["env_kwargs"])
    sensors = arguments["sensors"]
    shown = f"the sensors `{sensors}`" if isinstance(sensors, str) else f"the channels {', '.join(sensors)}"
    frames = config["hyperparameters"].get("frame_stack", 1)
    memory = f", its last {frames} observations ({frames / 10:g} s)" if frames > 1 else ""
    if "lstm" in str(config["hyperparameters"]["policy"]).lower():
        memory += ", and remembers what it saw (an LSTM)"
    rig = ", nor the rig" if home_suite(config["env_id"]).startswith("unknown") else ""
    return (
        f"# `{name}`\n\n"
        f"{config['algorithm'].upper().replace('_', ' ')} for `{config['env_id']}`: bring a drill string out of "
        "stick-slip and hold it calm at the target speed, by moving the drive's speed reference ten times a second. "
        f"The agent sees {shown}{memory}. It is told neither the normal force nor the friction{rig}.\n"
    )


def _scores(seeds: Mapping[str, Any], home: str) -> str:
    count, shipped = len(seeds["seeds"]), seeds["shipped"]
    lines = [
        "## Scores\n",
        f"On {seeds['rigs'][home]:,} held-out {_what(home)}, the chapter's cases aside. Of {count} training seeds, "
        f"the interquartile mean with its 95 % bootstrap interval over seeds. {SHARED_DRAWS}\n",
        _by_suite(MAIN, "main", seeds["pooled"]),
        f"\n*{markdown.sentence(MAIN.caption)}*\n",
        f"The shipped seed, {shipped}, is the median one by mitigated share in `{home}`; its scores, with 95 % "
        "intervals over rigs:\n",
        _by_suite(MAIN, "main", seeds["alone"]),
        "\nAction 0 on the same drive and rigs, where the reference stays at the target:\n",
        _by_suite(MAIN, "main", seeds["action_zero"]["suites"]),
        f"\nMitigated by hardness in `{home}`, all seeds and the shipped one:\n",
        _two_rows(HARDNESS, "hardness", seeds, home),
        f"\n*{markdown.sentence(HARDNESS.caption)}*\n",
        f"Other scores in `{home}`:\n",
        _two_rows(OTHERS, "others", seeds, home),
        f"\n*{markdown.sentence(OTHERS.caption)}*\n",
        f"Every seed in `{home}` (made with `{seeds['command']}`):\n",
    ]
    headings = ("seed", "mitigated", "below ω_c", "bistable", "above", "to calm, s", "cost", "training, min")
    rows = []
    for seed, one in seeds["seeds"].items():
        label = f"{seed}{' (shipped)' if int(seed) == shipped else ''}"
        rows.append([label, *_of_seed(one["scores"]), _minutes(one["seconds"])])
    tables = seeds["action_zero"]["suites"][home]
    row = {heading: one["value"] for heading, one in {**tables["main"], **tables["others"]}.items()}
    rows.append([SAME_DRIVE, *_of_seed(row), ""])
    return "\n".join([*lines, markdown.table(headings, rows)]) + "\n"


def _of_seed(row: Mapping[str, float | None]) -> list[str]:
    """The scores of one seed as entries of the table of all of them."""
    shares = [_number(row[heading], 3) for heading in ("mitigated", "below ω_c", "bistable", "above")]
    return [*shares, _number(row["to calm"], 1), _number(row["cost"], 3)]


def _failures(seeds: Mapping[str, Any], home: str) -> str:
    held = seeds["endurance"]
    without = seeds["action_zero"]["endurance"]
    shares = [[who, *(f"{one[time]:.3f}" for time in held)] for who, one in (("agent", held), (SAME_DRIVE, without))]
    counts = seeds["failures"]
    total = {name: sum(count[name] for count in counts.values()) for name in ("rigs", "failed", "calm")}
    rows = [[what, *(str(count[name]) for count in counts.values())] for what, name in _COUNTED.items()]
    return (
        f"## Where it fails\n\nAll seeds together: {seeds['fails']}\n\n"
        f"Of {total['rigs']:,} {_what(home, total['rigs'] > seeds['rigs'][home])}, the shipped seed does not mitigate "
        f"{total['failed']:,}, of which {total['calm']:,} are calm but off the target. By hardness:\n\n"
        f"{markdown.table(['', *counts], rows)}\n\n"
        "Every one of them is in [`failures.csv`](failures.csv), with its friction, target and scores, the hardest "
        "first.\n\n"
        "The suites' episodes last 60 s. The shipped seed, left to itself for longer, holds this share of rigs calm at "
        "the target:\n\n"
        f"{markdown.table(['after', *(f'{time} s' for time in held)], shares)}\n\n"
        f"{_elsewhere(home)}\n"
    )


def _elsewhere(home: str) -> str:
    """What is not known of rigs that the agent has not met."""
    if home.startswith("unknown"):
        return "Rigs farther from the nominal one than those of `unknown_hard`, and other drives, were not tried."
    return "Rigs unlike those of the package (another string, another drive) were not tried: train anew for them."


def _use(name: str, agent: Agent) -> str:
    drive = (
        "It was trained on the rig's own drive."
        if agent.drive is None
        else f"It works through a softened drive: {_drive(agent.drive)}. On another drive it is not the agent "
        "that was scored."
    )
    example = EXAMPLE.replace("NAME", name).replace("SEED", str(_seed_that_sticks(agent)))
    return (
        f"## Use\n\n{drive}\n\n```python\n{example}```\n\n{_verdict(agent.config['env_id'])}"
        f"`python eval.py constant z_torque {name} --env {agent.config['env_id']}` compares it, "
        f"`python -m agents.export {name}` writes it as one ONNX file that needs neither this package "
        f"nor PyTorch.\n"
    )


def _seed_that_sticks(agent: Agent) -> int:
    """The first seed whose rig sticks and slips without an agent; others turn steadily even where it is asked for."""
    env = agent.make_env()
    starts = (env.reset(seed=seed, options={"start": "stick_slip"})[1]["start"] for seed in range(100))
    return next(seed for seed, start in enumerate(starts) if start == STICK_SLIP)


def _drive(drive: Drive) -> str:
    """The settings of a drive in words."""
    share = drive.back_emf_share
    loop = f"k_p = {drive.k_p:.4g} V s/rad and k_i = {drive.k_i:.4g} V/rad in the speed loop"
    return f"{loop}, with {share:.0%} of the back-EMF made up for, while it runs" if share else f"{loop} while it runs"


def _training(config: Mapping[str, Any], seeds: Mapping[str, Any]) -> str:
    chosen, made = config["hyperparameters"], config["provenance"]
    times = [one["seconds"] for one in seeds["seeds"].values()]
    machines = sorted({one["machine"] for one in seeds["seeds"].values()})
    versions = ", ".join(f"{package} {number}" for package, number in made["versions"].items() if number)
    rows = [(f"`{key}`", f"`{json.dumps(value)}`") for key, value in chosen.items() if key != "env_kwargs"]
    rows += [(f"environment: `{key}`", f"`{json.dumps(value)}`") for key, value in config["env_kwargs"].items()]
    steps = imitation_steps(config)
    imitated = f"{steps:,} steps in imitation of `{chosen['imitation']['teacher']}`, then " if steps else ""
    spent = (
        f"{training_minutes(seeds)} minutes a seed (median; {_minutes(min(times))} to {_minutes(max(times))})"
        if all(times)
        else "not recorded"
    )
    return (
        f"## Training\n\n```sh\n{shlex.join(['python', *config['command']])}\n```\n\n"
        f"Seed of what is shipped: {seeds['shipped']}. {imitated}{chosen['n_timesteps']:,} steps; wall time, with what "
        f"else the machine did: {spent}. Machine: {'; '.join(machines)}. {made['date']}, Python {made['python']}, "
        f"{versions}.\n\n{markdown.table(('hyperparameter', 'value'), rows, 2)}\n"
    )


def _beside(name: str, trained: Path) -> list[str]:
    """The other shipped agents of the same environment beside this one; nothing where there are none."""
    env_id = read_config(trained / name)["env_id"]
    names = [one for one in shipped(trained) if read_config(trained / one)["env_id"] == env_id]
    found = {one: seeds for one in names if (seeds := read_seeds(trained / one)) is not None}
    if len(found) < 2:
        return []
    lines = [
        f"## Beside the other agents of {env_id}\n",
    ]
    home = home_suite(env_id)
    headings = ("agent", f"mitigated in `{home}`", SAME_DRIVE, "steps", "training, min", "size, kB")
    rows = []
    for one, seeds in found.items():
        row = stored_row(seeds["pooled"][home]["main"])
        steps = read_config(trained / one)["hyperparameters"]["n_timesteps"]
        size = (trained / one / MODEL).stat().st_size / 1024
        share = f"{row['mitigated'].value:.3f}"
        without = f"{seeds['action_zero']['suites'][home]['main']['mitigated']['value']:.3f}"
        rows.append((f"`{one}`", share, without, f"{steps:,}", training_minutes(seeds), f"{size:.0f}"))
    return ["\n".join([*lines, markdown.table(headings, rows)]) + "\n"]


def _by_suite(table: Table, name: str, suites: Mapping[str, Any]) -> str:
    rows: dict[str, Row] = {f"`{suite}`": stored_row(tables[name]) for suite, tables in suites.items()}
    return markdown_table(table, rows, {}, "suite")


def _two_rows(table: Table, name: str, seeds: Mapping[str, Any], home: str) -> str:
    rows = {
        "all seeds": stored_row(seeds["pooled"][home][name]),
        f"seed {seeds['shipped']}": stored_row(seeds["alone"][home][name]),
        SAME_DRIVE: stored_row(seeds["action_zero"]["suites"][home][name]),
    }
    return markdown_table(table, rows, {}, "")


def _what(home: str, more: bool = False) -> str:
    """What a suite's episodes are called, where there may be `more` that follow it."""
    if home not in OF_ONE_RIG:
        return f"episodes of `{home}`"
    return f"rigs, the suite `{home}` and those that follow it" if more else "rigs a suite"


def _number(value: float | None, digits: int) -> str:
    return "none" if value is None else f"{value:.{digits}f}"


def _minutes(seconds: float | None) -> str:
    return "not recorded" if seconds is None else f"{seconds / 60:.1f}"
