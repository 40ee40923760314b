"""The card of a data set: what it is, how it was made, who plays how well in it, how to load it, and its limits."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from agents.dataset.recipe import BLOCK, Player, Recipe
from agents.dataset.recording import ABOUT, INFOS
from drillrig_env import markdown
from drillrig_env.evaluation.provenance import in_words, provenance
from drillrig_env.evaluation.scores import REGIONS
from drillrig_env.seeds import DATASET_SEEDS

_LOAD = """\
import minari

data = minari.load_dataset("ID")  # or minari.MinariDataset("FOLDER/data"), wherever it lies
env = data.recover_environment()
about = list(data.storage.get_episode_metadata(data.episode_indices))
for episode, told in zip(data, about):
    print(told["policy"], told["seed"], episode.observations.shape, episode.rewards.sum(), told["mitigated"])
"""


def card(
    dataset_id: str,
    recipe: Recipe,
    players: Sequence[Player],
    recorded: Mapping[str, Mapping[str, np.ndarray]],
    command: str,
    megabytes: float,
) -> str:
    """The card of the data set that holds the episodes of `players`, as Markdown.

    `recorded` has what was found of every policy of the recipe, by the names of ABOUT.
    """
    from minari import __version__

    own = [player.name for player in players]
    made = in_words(provenance(), {"minari": __version__})
    steps = round(players[0].task.steps)
    first, last = recipe.first_seed, recipe.first_seed + recipe.episodes - 1
    count = len(own) * recipe.episodes
    return "\n".join(
        [
            f"# {dataset_id}\n",
            f"{count:,} episodes of {steps} control steps in `{recipe.env_id}`: "
            f"{markdown.listed(f'`{name}`' for name in own)} {'bring' if len(own) > 1 else 'brings'} a drill string "
            "out of stick-slip and to a target speed, by moving the drive's speed reference ten times a second. "
            f"{megabytes:.0f} MB, in Minari's format.\n",
            "## How good the policies are\n",
            "Scores of every policy that was recorded along with this data set, on the same rigs; mitigated: calm and "
            "within 5 % of the target over the last 10 s, also below the critical speed, from there to the fold "
            "(bistable) and above it:\n",
            markdown.table(
                ("policy", "in here", "mitigated", *REGIONS, "return, mean", "least", "largest"),
                [_scores(name, name in own, about) for name, about in recorded.items()],
                2,
            ),
            f"\n## How it was made\n\n```sh\n{command}\n```\n",
            f"{made}. The same command gives the same episodes bit for bit with the same versions on the same kind of "
            "processor.\n",
            f"Seeds {first} to {last}, the same for every policy, from a range of their own, {DATASET_SEEDS.start} to "
            f"{DATASET_SEEDS[-1]} ({BLOCK:,} for each `--seed`): no agent of the package has trained on them and no "
            "suite holds them, so what learns from these episodes can be judged on the suites.\n",
            "Policies act without exploration. Environment beside its defaults: "
            f"`{json.dumps(dict(players[0].env_kwargs), ensure_ascii=False)}`.\n",
            "## What is in it\n",
            "Of each episode, all that Minari asks for: `observations` (one more than steps), `actions` (-1 to 1, the "
            "rate of the speed reference over the slew limit), `rewards`, `terminations` (never), `truncations` (at "
            f"the end); and the infos {markdown.listed(f'`{name}`' for name in INFOS)} at every step. What holds for "
            "an episode as a whole is in its metadata:\n",
            markdown.table(("name", "unit", "meaning"), [(f"`{name}`", *words) for name, words in ABOUT.items()], 3),
            f"\n## Load it\n\n```python\n{_LOAD.replace('ID', dataset_id)}```\n",
            _limits(recipe, recorded),
            "## Licence\n\nMIT, as the package that made it.\n",
        ]
    )


def _scores(name: str, inside: bool, about: Mapping[str, np.ndarray]) -> list[str]:
    mitigated, returns = about["mitigated"], about["return"]
    shares = [_share(mitigated[about["region"] == region]) for region in REGIONS]
    ends = [f"{value:.1f}" for value in (returns.mean(), returns.min(), returns.max())]
    return [f"`{name}`", "yes" if inside else "no", _share(mitigated), *shares, *ends]


def _share(outcomes: np.ndarray) -> str:
    return f"{outcomes.mean():.3f}" if len(outcomes) else "none"


def _limits(recipe: Recipe, recorded: Mapping[str, Any]) -> str:
    beside = " Between policies they differ in nothing but who plays." if len(recorded) > 1 else ""
    return (
        "## Known limits\n\n"
        "- A simulated laboratory rig, not a field record; see the package's page on validation.\n"
        "- Deterministic policies: in each state one action, and little of what lies beside their paths. Methods that "
        "need noisy actions need the policies mixed.\n"
        f"- {recipe.episodes:,} rigs.{beside}\n"
        "- Episodes end by the clock alone, so that a value at their end is to be bootstrapped (truncated, not "
        "terminated).\n"
        "- Episode metadata gets lost where Minari combines data sets; record with `--mixed` instead.\n"
    )
