"""How pictures name and colour the policies, so that all of them agree."""

from __future__ import annotations

from drillrig_env.evaluation.results import Results

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "0.1")
"""Colours of Okabe and Ito, but for their yellow, which is lost on white."""

DASHES = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)))
"""Line styles, which change once the colours are used up."""


def suite_words(results: Results, suite: str) -> str:
    """Which suite, how many rigs, and whose sensors, for a caption."""
    about = results.config["suites"][suite]
    return f"suite {suite} ({about['description']}), {about['rigs']} rigs, {results.config['env']}"
