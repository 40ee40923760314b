"""Control designed on a rig as a minute of its records tells it, beside what knows less of the rig, and more.

    python -m benchmarks.calibrated_rigs --rigs 64            # writes docs/agents/calibrated.json
    python -m benchmarks.calibrated_rigs --rigs 8 --tuning --json few.json  # rigs to try things on, and no verdict

Of each rig of the suite `unknown` a logger writes one minute at 50 Hz, apart from all episodes: top speed, current and
voltage with the noise of the surface sensors, speeds in steps, glitches and a gap; the speed reference; and the normal
force, as set. For 12 s the bit is free and the speed steps; then, at 20 N, the speed falls slowly from 6 to 2 rad/s,
and last it steps between 1.2 and 2.5 rad/s, where most rigs stick and slip.

A rig and its friction are fitted to that from the nominal ones, with the drive's gains as set and every other parameter
known beforehand no better than as the suite draws it: string, discs and friction within a factor of 2, the motor within
10 %. Where the fit fails, tells of a misfit, or cannot be designed for, the nominal rig stays in its place, and is
counted. `LQGCalibrated` is `lqg` with filter, gains and law of friction of what was fitted. It plays the 16 episodes of
that rig, as do all that it stands beside; `ppo_unknown` among them has no record, and finds out while it controls.

The file is written after each rig, and what it holds is not fitted again: a run that was stopped goes on when the
command is given again, also with more rigs. Until they are judged the verdict on those before stays, a count of
mitigated episodes for each of the first rigs.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from baselines import LQG, Baseline
from baselines.calibrated import LQGCalibrated
from baselines.for_fleets import LQGOfFleet
from baselines.told import LQGOfRig, LQROfRig
from baselines.tune import tuning_suite
from benchmarks.calibration import Kind
from benchmarks.measure import note, print_table, write_json
from benchmarks.minute_of_records import KNOWN, NOMINAL, Found, fleet_of, found_of, kinds_of
from drillrig_env.allowed import NOT_NEGATIVE, Allowed, File
from drillrig_env.calibrate.unknowns import values_of
from drillrig_env.command_line import Parser, command
from drillrig_env.evaluation.report import cell
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.statistics import Estimate, mean, over_rigs
from drillrig_env.evaluation.suites import DRAWS, LARGEST_FLEET, Suite, suite
from drillrig_env.files import check_writable_file, read_json
from drillrig_env.flags import add_engine_arguments, engine_of, of_kind
from drillrig_env.parameters import checked
from drillrig_env.policy import Policy, load

COMMAND = "python -m benchmarks.calibrated_rigs"
FILE = Path(__file__).parents[1] / "docs" / "agents" / "calibrated.json"
RIGS = 64

_SIZE = Allowed(1, LARGEST_FLEET, whole=True)
_REMEDY = "name another file with --json, or begin anew with --overwrite"

POLICIES: dict[str, type[Baseline]] = {
    "`lqg`": LQG,
    "`lqg`, tuned on a fleet": LQGOfFleet,
    "`LQGCalibrated`": LQGCalibrated,
    "`LQGOfRig` *": LQGOfRig,
    "`LQROfRig` *": LQROfRig,
}
"""Who is judged, by what the table calls them; * is told what no real rig tells."""

AGENT = "ppo_unknown"
_CALIBRATED = "`LQGCalibrated`"


def mitigated(judged: Suite, found: Sequence[Found]) -> dict[str, npt.NDArray[Any]]:
    """Of each policy whether it mitigated each episode of a suite, shape (episodes,)."""
    fleet = judged.scenario.rigs
    policies: dict[str, Policy] = {
        name: kind("surface", fleet=fleet, **({"found": fleet_of(found)} if kind is LQGCalibrated else {}))
        for name, kind in POLICIES.items()
    }
    outcomes = {}
    for name, policy in {**policies, f"`{AGENT}`": load(AGENT)}.items():
        outcomes[name] = score(run(policy, judged, sensors="surface", threads=1))["mitigated"]
        note(f"{name}: {outcomes[name].mean():.3f}")
    return outcomes


def rows_of(outcomes: Mapping[str, npt.NDArray[Any]], rigs: int) -> list[list[str]]:
    """A row a policy: its share, its share less that of `lqg`, and that of the calibrated one less its own."""
    place = np.repeat(np.arange(rigs), len(outcomes[_CALIBRATED]) // rigs)

    def less(more: str, one: str) -> str:
        return (
            "" if more == one else _in_words(over_rigs(outcomes[more] * 1.0 - outcomes[one], place, mean), signed=True)
        )

    return [
        [name, _in_words(over_rigs(own, place)), less(name, "`lqg`"), less(_CALIBRATED, name)]
        for name, own in outcomes.items()
    ]


def errors_of(kinds: Sequence[Kind], found: Sequence[Found]) -> list[list[str]]:
    """A row a parameter: how far off the nominal value and the one found are, at the median and at the 90 % point."""
    truths, rows = [values_of(kind.rig, kind.friction) for kind in kinds], []
    known = [NOMINAL | one.values for one in found]
    for name in (*KNOWN, "J_1 + J_2"):
        true, row = np.log([_value(one, name) for one in truths]), [f"`{name}`"]
        for values in ([NOMINAL] * len(found), known):
            away = np.abs(np.log([_value(one, name) for one in values]) - true)
            row += [f"{share:.0%}" for share in np.expm1(np.quantile(away, (0.5, 0.9)))]
        rows.append(row)
    return rows


def _value(values: Mapping[str, float], name: str) -> float:
    """A parameter by its name, or a sum of some."""
    return sum(values[part] for part in name.split(" + "))


def _in_words(found: Estimate, signed: bool = False) -> str:
    value, interval = cell(found, 3, signed)
    return f"{value} ({interval})" if interval else value


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Fit the rigs, keep what is found of each, then judge all policies on them."""
    parser = Parser(prog=COMMAND, description=__doc__)
    add = parser.add_argument
    add(
        "--rigs",
        type=of_kind(_SIZE),
        default=RIGS,
        help=f"first rigs of the suite, fitted and judged (default: {RIGS})",
    )
    add("--seed", type=of_kind(Allowed(0, whole=True)), default=0, help="of the records (default: 0)")
    add("--tuning", action="store_true", help="rigs of a fleet to tune on, in place of the suite's own")
    add("--json", type=of_kind(File()), default=FILE, help="the file (default: docs/agents/calibrated.json)")
    add("--overwrite", action="store_true", help="begin anew, whatever the file holds")
    add_engine_arguments(parser, "rigs")
    chosen = parser.parse_args(arguments)
    judged = (tuning_suite if chosen.tuning else suite)("unknown", chosen.rigs)
    kinds, made = kinds_of(judged), {"seed": chosen.seed, "tuning": chosen.tuning}
    check_writable_file(chosen.json)
    try:
        anew = chosen.overwrite or not chosen.json.is_file()
        found, verdict = ({}, {}) if anew else _of_before(chosen.json, made, chosen.rigs)
        engine = engine_of(chosen)
    except (ValueError, ImportError, OSError) as error:
        parser.error(str(error))
    line = shlex.join([*COMMAND.split(), *(sys.argv[1:] if arguments is None else arguments)])

    def keep(judged: Mapping[str, list[int]], announce: bool = False) -> None:
        rigs = [{"rig": number, **asdict(one)} for number, one in sorted(found.items())]
        more = {"mitigated": judged} if judged else {}
        write_json(chosen.json, {"command": line, **made, **more, "rigs": rigs}, announce=announce)

    missing = [number for number in range(chosen.rigs) if number not in found]
    with engine:
        pieces = [(number, kinds[number]) for number in missing]
        for done, (place, one) in enumerate(engine.each(partial(found_of, chosen.seed), pieces), 1):
            found[missing[place]] = one
            keep(verdict)
            note(f"{done} of {len(missing)} rigs: {one.seconds:.0f} s{', ' * bool(one.failed)}{one.failed}")
    known = [found[number] for number in range(chosen.rigs)]
    outcomes = mitigated(judged, known)
    counts = {name: own.reshape(chosen.rigs, -1).sum(axis=1).tolist() for name, own in outcomes.items()}
    print_table(["policy", "mitigated", "less `lqg`", "calibrated less it"], rows_of(outcomes, chosen.rigs))
    print()
    headings = ["parameter", "nominal off by", "9 of 10 within", "found off by", "9 of 10 within"]
    print_table(headings, errors_of(kinds, known))
    failed = sum(bool(one.failed) for one in known)
    print(f"\n{chosen.rigs} rigs; {failed} of the fits failed; {np.mean([one.seconds for one in known]):.1f} s a fit")
    keep(counts, announce=True)


def _of_before(file: Path, made: Mapping[str, Any], rigs: int) -> tuple[dict[int, Found], dict[str, list[int]]]:
    """What a file holds: the rigs by number, and the verdict on the first of them, empty where there is none.

    `ValueError` where it is damaged, of other records or of more rigs than are asked for.
    """
    earlier = read_json(file, _REMEDY).get("results")
    try:
        if not isinstance(earlier, dict) or not isinstance(earlier.get("rigs"), list):
            raise ValueError("it has no results with rigs")
        for name in made:
            if name not in earlier:
                raise ValueError(f"it does not tell {name}")
        found = dict(map(_rig_of_before, earlier["rigs"]))
        if len(found) != len(earlier["rigs"]):
            raise ValueError("it has a rig twice")
        verdict = _verdict_of_before(earlier.get("mitigated", {}), len(found))
    except ValueError as error:
        raise ValueError(f"{file} is damaged: {error}; {_REMEDY}") from error
    for name, value in made.items():
        if earlier[name] != value:
            raise ValueError(f"{file} does not hold these rigs (its {name} is {earlier[name]}, not {value}); {_REMEDY}")
    if found and max(found) >= rigs:
        raise ValueError(f"{file} holds more rigs, up to number {max(found)}, than --rigs {rigs} asks for; {_REMEDY}")
    return found, verdict


def _rig_of_before(entry: Any) -> tuple[int, Found]:
    """A rig's number and what was found of it. `ValueError` where this is none that a fit has left."""
    if not isinstance(entry, dict):
        raise ValueError(f"{entry!r} is no rig")
    number: int = checked("rigs", "rig", entry.get("rig"), "", Allowed(0, LARGEST_FLEET - 1, whole=True))
    seconds: float = checked(f"rig {number}", "seconds", entry.get("seconds"), "s", NOT_NEGATIVE)
    values, failed = entry.get("values"), entry.get("failed")
    if not isinstance(values, dict) or not isinstance(failed, str):
        raise ValueError(f"rig {number} does not tell values and failed")
    if values.keys() != (set() if failed else NOMINAL.keys()):
        raise ValueError(f"rig {number} has neither each parameter's value nor the reason why it has none")
    found = Found(values, failed, seconds)
    try:
        fleet_of([found]).members()
    except (ValueError, TypeError) as error:
        raise ValueError(f"rig {number}: {error}") from error
    return number, found


def _verdict_of_before(mitigated: Any, rigs: int) -> dict[str, list[int]]:
    """The count of each of the first rigs by policy. `ValueError` where it is none."""
    count = Allowed(0, DRAWS, whole=True)
    if not isinstance(mitigated, dict) or not all(isinstance(counts, list) for counts in mitigated.values()):
        raise ValueError("mitigated has no counts by policy")
    lengths = {len(counts) for counts in mitigated.values()}
    if len(lengths) > 1 or not lengths <= set(range(1, rigs + 1)):
        raise ValueError("mitigated has not a count for each of the first rigs")
    return {name: [checked("mitigated", name, one, "", count) for one in own] for name, own in mitigated.items()}


if __name__ == "__main__":
    raise SystemExit(main())
