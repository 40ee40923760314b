"""docs/results.md with its pictures, from results that `eval.py` has left.

Results are taken in as docs/results/ENVIRONMENT, packed; the pictures lie in docs/images/results. What a person has
found goes into docs/results/findings.md, which the page quotes.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from docs.make.contents import with_contents
from drillrig_env.env.registration import ENVIRONMENTS
from drillrig_env.evaluation.findings import where_each_fails, who_wins
from drillrig_env.evaluation.histories import Histories, worth_showing
from drillrig_env.evaluation.provenance import in_words
from drillrig_env.evaluation.report import markdown_table
from drillrig_env.evaluation.results import MARKS, Results
from drillrig_env.evaluation.store import clear, read, read_histories, save
from drillrig_env.evaluation.tables import DIFFERENCES, TABLES, Row, Table, differences, stored_row
from drillrig_env.markdown import sentence

COMMAND = "python -m docs.make results"
PICTURES = {
    "scores_default": "Scores of every policy with their intervals",
    "calming_default": "Share of rigs that are calm, over time",
    "map_default": "Who mitigates what over target and normal force",
    "histories_default_below": "One rig below its critical speed over time",
    "histories_default_bistable": "One rig between critical speed and fold over time",
    "histories_load_below": "One rig over time that a load step puts below its critical speed",
}
"""The pictures that the page shows, and what is seen on them."""

_INTRODUCTION = f"""# Results

Every policy faces the same random rigs, starts, loads and measurement noise, and moves the drive's speed reference.
Some set the drive's gains as well; what the drive then does, no noise, delay or slew limit touches. A rig is
*mitigated* when its last 10 s are calm (a stick-slip index below 0.1) with a mean bit speed within 5 % of the target,
and *calm* when that holds at any mean speed. Below the critical speed ω_c steady rotation is unstable; from there to
the fold (*bistable*) both it and stick-slip are stable; above the fold stick-slip dies by itself. The hardness q is
the fall of a rig's friction with speed at the target over what the bare drive can bear.
Intervals are at 95 %: Wilson's for rates, bootstrap over rigs otherwise; for an agent with several training seeds, of
the interquartile mean over seeds. They have a digit less than the values, rounded outwards. Marks: {MARKS}.

This page and its pictures come from the stored results of all episodes with `{COMMAND}`.
"""


def take_in(folder: Path, docs: Path) -> None:
    """Copy a folder of results, packed, to where the page finds it. `ValueError` for results that are not finished."""
    results, kept = read(folder), read_histories(folder)
    if not results.estimates:
        raise ValueError(f"the results in {folder} are not finished; go on with: eval.py ... --resume")
    store = docs / "results" / str(results.config["env"])
    shown = Histories()
    for (suite, policy, region), history in kept.kept.items():
        there = kept.of(suite, region)
        if f"histories_{suite}_{region}" in PICTURES and policy in worth_showing(results.scores[suite], there):
            shown.kept[suite, policy, region] = history
    clear(store)
    save(store, results, shown, packed=True)


def page(docs: Path) -> str:
    """The page as Markdown. `ValueError` where no results have been taken in."""
    stored = stored_results(docs)
    parts = [_INTRODUCTION]
    words = docs / "results" / "findings.md"
    if words.exists():
        parts.append(f"## What was found\n\n{words.read_text(encoding='utf-8').strip()}\n")
    for env, results in stored.items():
        parts += _environment(env, results)
    parts += _between(stored)
    parts += [_made(stored)]
    return with_contents("\n".join(parts))


def draw_pictures(docs: Path) -> list[Path]:
    """Draw the pictures of the page and list them."""
    from drillrig_env.evaluation.pictures import draw_all

    paths = []
    for env, results in stored_results(docs).items():
        histories = read_histories(docs / "results" / env)
        paths += draw_all(results, histories, docs / "images" / "results", PICTURES, f"{env}_")
    return paths


def stored_results(docs: Path) -> dict[str, Results]:
    """The results that were taken in, by environment. `ValueError` where there are none."""
    folders = {env: docs / "results" / env for env in ENVIRONMENTS}
    found = {env: read(folder) for env, folder in folders.items() if folder.is_dir()}
    if not found:
        raise ValueError(f"{docs / 'results'} holds no results; name folders of results to take in")
    return found


def _environment(env: str, results: Results) -> list[str]:
    """Everything about the policies with one environment's sensors, the headline first."""
    suites = sorted(results.estimates, key=lambda suite: suite != "default")
    parts = [f"## {env}: sensors `{ENVIRONMENTS[env]['sensors']}`\n"]
    for number, suite in enumerate(suites):
        about = results.config["suites"][suite]
        parts.append(f"### {env}, suite `{suite}`: {about['description']} ({about['rigs']} rigs)\n")
        for name, table in {**TABLES, "differences": DIFFERENCES, "loss": DIFFERENCES}.items():
            parts += _table(results, suite, name, table)
        parts += [
            f"![{words}](images/results/{env}_{name}.png)\n"
            for name, words in PICTURES.items()
            if name.split("_")[1] == suite
        ]
        if number == 0:
            parts += [f"### {env}: who wins where\n", *(f"- {sentence}" for sentence in who_wins(results)), ""]
            parts += [
                f"### {env}: where each fails\n",
                *(f"- {sentence}" for sentence in where_each_fails(results, suite)),
                "",
            ]
    return parts


def _table(results: Results, suite: str, name: str, table: Table) -> list[str]:
    """One table of a suite with what it shows; none where there is nothing to show."""
    policies = results.estimates[suite]
    rows = {policy: stored_row(tables[name]) for policy, tables in policies.items() if name in tables}
    if not rows:
        return []
    heads = {
        "hardness": "Mitigated by hardness:\n\n",
        "others": "Other scores:\n\n",
        "differences": f"Less `{results.config['reference']}` on the same rigs:\n\n",
        "loss": "What noise, delay and half the slew cost: each policy less itself in `default`, on the same rigs:\n\n",
    }
    return [f"{heads.get(name, '')}{markdown_table(table, rows, results.marks)}\n\n*{sentence(table.caption)}*\n"]


def _between(stored: Mapping[str, Results]) -> list[str]:
    """What a policy loses from the first environment's sensors to the second's, on the same rigs of `default`."""
    if len(stored) < 2:
        return []
    (rich, first), (poor, second) = list(stored.items())[:2]
    ours, theirs = second.scores.get("default", {}), first.scores.get("default", {})
    same = [policy for policy in ours if policy in theirs and len(ours[policy]["seed"]) == len(theirs[policy]["seed"])]
    rows: dict[str, Row] = {policy: differences(ours[policy], theirs[policy]) for policy in same}
    if not rows:
        return []
    return [
        f"## From {rich} to {poor}\n",
        f"Each policy in `default` with the sensors of {poor}, less itself with those of {rich}, on the same rigs:\n",
        f"{markdown_table(DIFFERENCES, rows, second.marks)}\n\n*{sentence(DIFFERENCES.caption)}*\n",
    ]


def _made(stored: Mapping[str, Results]) -> str:
    """Command, date, machine and versions of every set of results."""
    lines = ["## How it was made\n"]
    for env, results in stored.items():
        lines.append(f"{env}: {in_words(results.provenance)}.\n")
        lines.append(f"```sh\n{results.config['command']}\n```\n")
    return "\n".join(lines)
