"""Start-up: what a user waits for before the first result."""

from __future__ import annotations

from benchmarks.parts.part import Part, Results, duration
from drillrig_env import markdown


def result(results: Results) -> list[tuple[str, str]]:
    """What a user waits for."""
    found = results["cases"].get("fresh install", {})
    tasks = (
        ("first", "import, first env step", "first step after an install, compilation included"),
        ("later", "import, first env step", "first step in later processes, import included"),
        ("later", "import drillrig_env", "`import drillrig_env`"),
    )
    return [
        (words, f"**{duration(found[process][task]['seconds'])}**")
        for process, task, words in tasks
        if task in found.get(process, {})
    ]


def tables(results: Results) -> list[str]:
    """Seconds by install and process."""
    tasks = list(results["tasks"])
    rows, failures = [], []
    for case, found in results["cases"].items():
        for process, words in (("first", "first process"), ("later", "later processes")):
            if done := found.get(process):
                cells = [f"{done[task]['seconds']:.2f}" if task in done else "-" for task in tasks]
                rows.append([f"{case}, {words}", *cells])
        if "fails" in found:
            failures.append(f"{case.capitalize()}: fails with `{found['fails']}`.")
    return [markdown.table(["seconds for", *tasks], rows), *failures]


STARTUP = Part(
    "startup",
    "Start-up",
    """Seconds within fresh processes, from before the import to after the result, without Python's own start. The first
process after an install compiles the kernels and stores them; later ones read them. Where the install folder is
read-only they are stored in the user's own cache folder, and without a home in the system's temporary folder.""",
    result,
    tables,
)
