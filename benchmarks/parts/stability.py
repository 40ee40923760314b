"""Stability analysis: seconds, and AUTO-07p beside it."""

from __future__ import annotations

from benchmarks.parts.part import Part, Results, duration
from drillrig_env import markdown


def result(results: Results) -> list[tuple[str, str]]:
    """What some analyses take."""
    shown = ("fold, a new rig", "critical speed and fold over 200 normal forces", "bifurcation diagram")
    return [
        (f"stability: {name}", f"**{duration(seconds)}**")
        for name, seconds in results["seconds"].items()
        if name.startswith(shown)
    ]


def tables(results: Results) -> list[str]:
    """Seconds of the analyses, Hopf point and fold beside AUTO's, and the map."""
    seconds = [[name, duration(value)] for name, value in results["seconds"].items()]
    columns = {"hopf": ".8f", "fold": ".6f", "seconds": ".3f"}
    peers = [
        [name, one["remark"], *(format(one[key], digits) if key in one else "-" for key, digits in columns.items())]
        for name, one in results.get("hopf_to_fold", {}).items()
    ]
    heads = ["Hopf point to fold, 10 N", "remark", "Hopf point, rad/s", "fold, rad/s", "seconds"]
    tables = [markdown.table(["DrillRig, 10 N", "time"], seconds), markdown.table(heads, peers, words=2)]
    if "agree" in (found := results.get("map", {})):
        side = round(found["points"] ** 0.5)
        tables.append(
            f"A map of {side} x {side} points by simulation from both starts, all {found['cores']} cores: "
            f"{found['seconds']:.1f} s. Of the {found['judged']:,} points clear of the curves of critical speed and "
            f"fold {100.0 * found['agree']:.2f} % agree with them."
        )
    return tables


STABILITY = Part(
    "stability",
    "Stability analysis",
    """On one core but for the map; compilation is not in the times. "A new rig" meets no cached tables. AUTO-07p gets
the model in Fortran, with the friction law as it stands but for its jump of 0.04 %, and with two smoothed laws.""",
    result,
    tables,
)
