"""Score action 0 on the drive and the rigs of a shipped agent: what there is without it.

python -m agents.shipping.action_zero      # of all shipped agents; writes their cards anew
python -m agents.shipping.action_zero ppo  # of some
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from agents.endurance import ENDURING, endurance
from agents.policy.action_zero import ActionZero
from agents.policy.run_folder import SEEDS, TRAINED, load_policy, seeds_of, shipped
from agents.shipping.card import tables_of_card, write_card
from agents.shipping.named import add_names_argument
from drillrig_env.command_line import Parser, command
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import DRAWS, home_suite, suite
from drillrig_env.evaluation.tables import all_estimates
from drillrig_env.files import json_text, write_text

COMMAND = "python -m agents.shipping.action_zero"
_NAME = "action 0"


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Score action 0 beside all shipped agents or those named."""
    parser = Parser(prog=COMMAND, description=__doc__)
    add_names_argument(parser)
    chosen = parser.parse_args(arguments)
    try:
        for name in chosen.names:
            add_action_zero(TRAINED / name)
        for name in shipped():  # a card tells of the other agents, too
            print(write_card(name).resolve())
    except ValueError as error:
        parser.error(error)


def add_action_zero(folder: Path) -> None:
    """Put what action 0 does in an agent's place into the agent's `seeds.json`.

    `ValueError` where `folder` is not that of a shipped agent.
    """
    about, agent = seeds_of(folder), load_policy(folder)
    found = in_its_place(agent.environment, about["rigs"], home_suite(agent.env_id))
    write_text(folder / SEEDS, json_text({**about, "action_zero": found}, indent=1))


def in_its_place(environment: Mapping[str, Any], rigs: Mapping[str, int], home: str = "default") -> dict[str, Any]:
    """What action 0 does in an agent's `environment`: its tables in the suites that `rigs` has, with how many of
    their episodes, and how long it holds that. `home` is the suite that the agent is chosen by.
    """
    policy = ActionZero(environment)
    scores = {}
    for name, number in rigs.items():
        of_fleet = suite(name, 1).scenario.rigs is not None
        drawn = suite(name, number // DRAWS if of_fleet else number)
        scores[name] = {_NAME: {"seed": np.full(drawn.rigs, ""), **score(run(policy, drawn))}}
    return {
        "suites": {
            name: tables_of_card(one[_NAME], name == home) for name, one in all_estimates(scores, _NAME).items()
        },
        "endurance": endurance(policy, min(rigs[home], ENDURING), suite_name=home),
    }


if __name__ == "__main__":
    raise SystemExit(main())
