"""How far any setting of a baseline could go: for every rig the best of many, chosen when all is over.

    python -m baselines.hindsight lqg --sensors surface   # settings around the tuned ones, 1,000 rigs for tuning

A controller is told nothing, so that it has one setting for all rigs. What none of many settings brings to its target
is beyond that law, whatever is tuned; what one of them does is still no promise, since nobody knows the rig before.
Prints the share mitigated by hardness with the tuned values, with the best single setting, and with each rig's best.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from baselines import BASELINES
from baselines.tune import scores_of, starting_point, tuning_suite
from drillrig_env.allowed import COUNT, Allowed
from drillrig_env.command_line import Parser, command
from drillrig_env.env.sensors import SENSORS
from drillrig_env.evaluation.suites import Suite
from drillrig_env.evaluation.tables import HARDNESS
from drillrig_env.flags import of_kind
from drillrig_env.markdown import table
from drillrig_env.progress import Progress

COMMAND = "python -m baselines.hindsight"
_SPREAD = 0.6  # of the logarithm of a setting around the tuned one


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Parse the command line, try the settings, and print the table."""
    able = [name for name, kind in BASELINES.items() if kind.tuned]
    parser = Parser(prog=COMMAND, description=__doc__)
    parser.add_argument("controller", choices=able, help="name of the baseline")
    parser.add_argument("--sensors", choices=list(SENSORS), default="state", help="default: state")
    parser.add_argument("--settings", type=of_kind(COUNT), default=70, help="how many are tried (default: 70)")
    parser.add_argument("--rigs", type=of_kind(COUNT), default=1000, help="default: 1000")
    parser.add_argument("--seed", type=of_kind(Allowed(low=0, whole=True)), default=0, help="of the settings")
    chosen = parser.parse_args(arguments)
    try:
        suite = tuning_suite("default", chosen.rigs)
        settings = settings_around(chosen.controller, chosen.sensors, chosen.settings, chosen.seed)
    except ValueError as error:
        parser.error(error)
    with Progress(chosen.controller, parts=1) as progress:
        hardness, mitigated = tried(chosen.controller, chosen.sensors, settings, suite, progress)
    print(in_words(hardness, mitigated))


def settings_around(controller: str, sensors: str, count: int, seed: int = 0) -> list[dict[str, float]]:
    """The tuned values of a baseline, then `count` - 1 others spread around them, within its bounds.

    `ValueError` where it has none for these sensors.
    """
    tuned = starting_point(controller, [sensors])
    if not tuned:
        raise ValueError(f"{controller} has no tuned values for the sensors {sensors}; tune it first")
    random = np.random.default_rng(seed)
    bounds = BASELINES[controller].tuned
    found = [tuned]
    for _ in range(count - 1):
        factors = np.exp(random.normal(0.0, _SPREAD, len(bounds)))
        found.append(
            {
                name: float(np.clip(tuned[name] * factor, *bounds[name]))
                for name, factor in zip(bounds, factors, strict=True)
            }
        )
    return found


def tried(
    controller: str, sensors: str, settings: Sequence[dict[str, float]], suite: Suite, progress: Progress | None = None
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
    """Hardness of the suite's rigs, shape (n,), and which of them each setting mitigates, shape (settings, n)."""
    mitigated = []
    for number, values in enumerate(settings):
        scores = scores_of(controller, values, sensors, suite)
        mitigated.append(scores["mitigated"].astype(np.bool_))
        if progress:
            progress.show(controller, number + 1, len(settings))
    return scores["hardness"].astype(np.float64), np.array(mitigated)


def in_words(hardness: npt.NDArray[np.float64], mitigated: npt.NDArray[np.bool_]) -> str:
    """The table: shares of all rigs and of those in each bin of hardness."""
    best = mitigated[int(np.argmax(mitigated.mean(axis=1)))]
    columns = {"all": np.ones(len(hardness), dtype=np.bool_)}
    for column in HARDNESS.columns:
        columns[column.heading] = column.chosen({"mitigated": best, "hardness": hardness})
    compared: dict[str, npt.NDArray[np.bool_]] = {
        "tuned": mitigated[0],
        f"best of {len(mitigated)} settings": best,
        "each rig's best": np.asarray(mitigated.any(axis=0)),
    }
    rows = [
        [words, *(f"{shares[chosen].mean():.3f}" if chosen.any() else "none" for chosen in columns.values())]
        for words, shares in compared.items()
    ]
    return table(["mitigated", *columns], rows)


if __name__ == "__main__":
    raise SystemExit(main())
