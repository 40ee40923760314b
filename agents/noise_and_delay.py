"""What noise and delay cost: shares of the suite `default` under measurements that are ever noisier and later.

    python -m agents.noise_and_delay             # of all shipped agents for the rig's own drive; a minute or two
    python -m agents.noise_and_delay --rigs 100  # roughly

Beside every agent stand, on the same rigs and sensors, action 0, `lqg` as it comes, and `lqg` that is told the delay.
The table and the picture go into the page of agents (`python -m docs.make agents`).
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from agents.policy.action_zero import SAME_DRIVE
from agents.policy.finding import at_slew_limit
from agents.policy.run_folder import TRAINED, load_policy, shipped
from drillrig_env import markdown
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.env.registration import ENVIRONMENTS
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import suite
from drillrig_env.files import check_writable_file, json_text, read_json, write_text
from drillrig_env.flags import of_kind
from drillrig_env.policy import Policy, make_policy
from drillrig_env.progress import Progress
from drillrig_env.scales import CONTROL_PERIOD

COMMAND = "python -m agents.noise_and_delay"
FILE = Path("agents") / "noise_and_delay.json"
RIGS = 1000

DELAYS = (0, 1, 2, 3, 4, 5)
"""Control steps that measurements come late."""

NOISES = {"DrillRig-v0": (0.0, 1.0), "DrillRigSurface-v0": (1.0, 2.0)}
"""Noise of each environment's measurements, times what is usual: what `gym.make` gives first, then more."""

TOLD = "`lqg`, told the delay"


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Run all of them and write the file."""
    parser = Parser(prog=COMMAND, description=__doc__)
    parser.add_argument("--rigs", type=of_kind(COUNT), default=RIGS, help=f"of the suite (default: {RIGS})")
    parser.add_argument("--docs", type=Path, default=Path("docs"), help="folder of the documentation (default: docs)")
    chosen = parser.parse_args(arguments)
    path = chosen.docs / FILE
    check_writable_file(path)
    line = shlex.join([*COMMAND.split(), *(sys.argv[1:] if arguments is None else arguments)])
    content: dict[str, Any] = {"command": line, "provenance": provenance(), "rigs": chosen.rigs, "delays": DELAYS}
    content["environments"] = shares(chosen.rigs)
    write_text(path, json_text(content, indent=1))
    print(path.resolve())


def shares(
    rigs: int, trained: Path = TRAINED, delays: Sequence[int] = DELAYS
) -> dict[str, dict[str, dict[str, list[float]]]]:
    """Mitigated shares for each of `delays` (control steps), by environment, noise and policy as tables say it."""
    found: dict[str, dict[str, dict[str, list[float]]]] = {}
    drawn = suite("default", rigs)
    with Progress("noise and delay", parts=len(NOISES)) as progress:
        for env_id, noises in NOISES.items():
            sensors = ENVIRONMENTS[env_id]["sensors"]
            found[env_id] = {f"{noise:g}": {} for noise in noises}
            policies = _policies(env_id, sensors, trained)
            asked = [(noise, delay) for noise in noises for delay in delays]
            for done, (noise, delay) in enumerate(asked, 1):
                policies[TOLD] = make_policy("lqg", sensors=sensors, delay=delay)
                for name, policy in policies.items():
                    mitigated = score(run(policy, drawn, sensors=sensors, noise=noise, delay=delay))["mitigated"]
                    found[env_id][f"{noise:g}"].setdefault(name, []).append(float(mitigated.mean()))
                progress.show(env_id, done, len(asked))
    return found


def _policies(env_id: str, sensors: Any, trained: Path) -> dict[str, Policy]:
    """Who is tried at every delay: the agents for an environment on the rig's own drive, and what they stand beside."""
    agents = {name: load_policy(trained / name) for name in shipped(trained)}
    return {
        **{
            f"`{name}`": at_slew_limit(agent)
            for name, agent in agents.items()
            if agent.env_id == env_id and agent.drive is None
        },
        "`lqg`": make_policy("lqg", sensors=sensors),
        TOLD: make_policy("lqg", sensors=sensors),  # made anew for every delay
        SAME_DRIVE: make_policy("constant", sensors=sensors),
    }


def read_shares(docs: Path) -> dict[str, Any] | None:
    """What the command has found; None where it has not run. `ValueError` where the file is damaged."""
    path = docs / FILE
    return read_json(path, f"make it again with: {COMMAND}") if path.is_file() else None


def section(content: Mapping[str, Any] | None) -> str:
    """The section of the page: a table an environment and noise; empty where nothing was found."""
    if content is None:
        return ""
    late = [f"{delay * CONTROL_PERIOD:.1f} s late" if delay else "at once" for delay in content["delays"]]
    lines = [
        "## What noise and delay cost\n",
        f"Mitigated shares of the {content['rigs']:,} rigs of `default`, for measurements that come up to "
        f"{max(content['delays']) * CONTROL_PERIOD:g} s late. One `lqg` is as it comes, the other is told how late "
        "they are; the agents are not.\n",
        "![Mitigated share over the delay of measurements](images/agents/noise_and_delay.png)\n",
    ]
    for env_id, by_noise in content["environments"].items():
        for noise, policies in by_noise.items():
            lines.append(f"`{env_id}`, {in_words(float(noise))}:\n")
            rows = [[name, *(f"{share:.3f}" for share in found)] for name, found in policies.items()]
            lines += [markdown.table(["", *late], rows), ""]
    return "\n".join(lines)


def in_words(noise: float) -> str:
    """A multiple of the usual noise."""
    return {0.0: "exact measurements", 1.0: "the usual noise", 2.0: "twice the usual noise"}[noise]


if __name__ == "__main__":
    raise SystemExit(main())
