"""Policies on suites in one call: what `drillrig evaluate` does, for Python."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from drillrig_env.command_line import Failed
from drillrig_env.engine import Engine, used
from drillrig_env.engine.likeness import likeness
from drillrig_env.evaluation.beginning import begin
from drillrig_env.evaluation.contest import config_of, run_contest
from drillrig_env.evaluation.contestants import contestant_of, find_contestants
from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.pieces import Told
from drillrig_env.evaluation.provenance import note_processors, provenance
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.store import save
from drillrig_env.evaluation.suites import LARGE, suite
from drillrig_env.evaluation.tables import all_estimates
from drillrig_env.files import owned
from drillrig_env.parameters import refuse
from drillrig_env.policy import find_policy
from drillrig_env.rig import RigLike

_WAYS_OUT = "resume=True goes on where all is the same; another folder holds others"


def evaluate(
    policies: Sequence[Any],
    suites: Sequence[str] = ("default",),
    rigs: int = 1000,
    *,
    env_id: str | None = None,
    rig: RigLike = None,
    engine: Engine | str | None = None,
    folder: Path | None = None,
    resume: bool = False,
    progress: Told | None = None,
) -> Results:
    """Put policies through suites; their scores by suite and policy, and the tables as numbers in `estimates`.

    A policy is whatever `find_policy` takes: a name, FILE.py:CLASS, a run's folder, a class or an object. `rigs` counts
    for suites that are drawn; more than 10,000 need a `folder`, where results are kept as `drillrig evaluate` does,
    and from where `resume` goes on. `env_id` and `rig` are as the command's flags. `engine` does the pieces, such as
    `Local(4)` or "ray" of `drillrig_env.engine`; the result is the same. `progress` hears the name of a policy, and how
    many of how many steps or pieces are done.

    Raises `ValueError` for what is not known or not allowed, `ImportError` for what is not installed, and `Failed` for
    policies that fail, once the others are done.

    >>> results = evaluate(["constant", "lqg"], rigs=20)
    >>> sorted(results.scores["default"])
    ['constant', 'lqg']
    """
    if rigs > LARGE and folder is None:
        raise refuse("evaluate", "rigs", rigs, "", f"<= {LARGE} without a folder to keep rows in")
    named = [str(one) for one in policies if isinstance(one, str | Path)]
    field, failures, conditions = find_contestants(named or ["constant"], env_id, rig=rig)
    own = [contestant_of(find_policy(one), conditions) for one in policies if not isinstance(one, str | Path)]
    field = [*(field if named else ()), *own]
    chosen = [suite(name, rigs, conditions.scales) for name in suites]
    reference = next((one.name for one in field), "")
    config = config_of(conditions, chosen, field, likeness()["drillrig"], "evaluate", reference)
    results, histories = Results(config, provenance()), Histories()
    with used(engine) as at, nullcontext() if folder is None else owned(folder):
        if folder is not None:
            results, histories = begin(folder, config, resume, ways_out=_WAYS_OUT)
        for one in chosen:
            failures += run_contest(one, field, results, histories, folder, progress, at)
        note_processors(results.provenance, at.processors)
        results.estimates = all_estimates(results.scores, reference)
        if folder is not None:
            save(folder, results, histories)
    if failures:
        raise Failed("; ".join(map(str, failures)))
    return results
