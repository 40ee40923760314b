"""What the numbers say, in plain words: who wins where, and where each policy fails."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.statistics import Estimate
from drillrig_env.evaluation.tables import HARDNESS, Row, Scores, stored_row
from drillrig_env.markdown import listed

_LEAST = 20
"""A share is called a policy's worst only where it stands on as many episodes."""

_REGIONS = {"below ω_c": "below ω_c", "bistable": "between ω_c and the fold", "above": "above the fold"}


def who_wins(results: Results) -> list[str]:
    """A sentence for the headline and for each of its regions, and one for each other suite."""
    headline = _rows(results, "default")
    asked = [("In the suite `default`", headline, "mitigated")]
    asked += [(f"In `default` {words}", headline, heading) for heading, words in _REGIONS.items()]
    asked += [
        (f"In `{suite}`", _rows(results, suite), "mitigated") for suite in results.estimates if suite != "default"
    ]
    return [_winners(words, rows, heading, results.privileged) for words, rows, heading in asked if rows]


def where_each_fails(results: Results, home: str = "default") -> list[str]:
    """A sentence a policy: its worst region, hardness and suite, and what becomes of the rigs that it fails.

    Region and hardness are those of the suite `home`, which is named where it is not `default`.
    """
    sentences, of_home = [], "" if home == "default" else f" of `{home}`"
    for policy in results.policies:
        worst = []
        headline = _rows(results, home).get(policy)
        if headline:
            regions = {words: headline[heading] for heading, words in _REGIONS.items()}
            worst.append(_worst(regions, f"region{of_home}"))
            bins = _rows(results, home, "hardness")[policy]
            worst.append(_worst({heading: bins[heading] for heading in HARDNESS.headings}, "hardness"))
        suites = {
            f"`{suite}`": rows[policy]["mitigated"]
            for suite in results.estimates
            if policy in (rows := _rows(results, suite))
        }
        worst.append(_worst(suites, "suite"))
        fates = _fates(results.scores.get(home, {}).get(policy), home)
        sentences.append(f"`{policy}`: worst " + ", ".join(part for part in worst if part) + f".{fates}")
    return sentences


def _rows(results: Results, suite: str, table: str = "main") -> dict[str, Row]:
    return {policy: stored_row(tables[table]) for policy, tables in results.estimates.get(suite, {}).items()}


def _winners(words: str, rows: Mapping[str, Row], heading: str, told: Mapping[str, bool]) -> str:
    """The best of those told nothing, all whose interval reaches into its own, and the best of those told."""
    fair = {policy: row[heading] for policy, row in rows.items() if not told.get(policy) and row[heading].count}
    others = {policy: row[heading] for policy, row in rows.items() if told.get(policy) and row[heading].count}
    if not fair:
        return f"{words} there is no policy that is told nothing."
    best = max(fair, key=lambda policy: fair[policy].value)
    level = [policy for policy, one in fair.items() if policy != best and one.high >= fair[best].low]
    text = f"{words} `{best}` mitigates {fair[best].value:.1%} ({fair[best].low:.1%} to {fair[best].high:.1%})"
    if level:
        shares = listed([f"`{policy}` ({fair[policy].value:.1%})" for policy in level])
        text += f", with an interval that overlaps those of {shares}"
    if others:
        top = max(others, key=lambda policy: others[policy].value)
        text += f"; told more than the sensors show, `{top}` mitigates {others[top].value:.1%}"
    return f"{text}."


def _worst(found: Mapping[str, Estimate], kind: str) -> str:
    """The entry of the smallest share that stands on enough episodes; empty where none does."""
    shares = {words: one.value for words, one in found.items() if one.count >= _LEAST}
    if not shares:
        return ""
    low = min(shares, key=lambda words: shares[words])
    return f"{kind} {low} ({shares[low]:.1%})"


def _fates(scores: Scores | None, suite: str) -> str:
    """What becomes of the rigs of a suite that are not mitigated."""
    if scores is None or bool(scores["mitigated"].all()):
        return ""
    failed = ~scores["mitigated"]
    calm = scores["calm"][failed]
    standing = ~calm & (scores["stuck"][failed] > 0.5)
    kinds = {
        "are calm, but not at the target": calm,
        "stand still for most of the time": standing,
        "shake": ~calm & ~standing,
    }
    parts = [f"{np.mean(kind):.0%} {words}" for words, kind in kinds.items() if kind.any()]
    return f" Of the rigs of `{suite}` that it does not mitigate {listed(parts)}."
