"""Record episodes of policies as data sets for offline reinforcement learning, in Minari's format.

    python -m agents.dataset --policies lqg,ppo,constant --episodes 1000
    python -m agents.dataset --env DrillRigSurface-v0 --policies lqg,z_torque --mixed
    python -m agents.dataset --policies my_controller.py:MyPolicy --env-kwargs scenario:wide duration:30.0

Each policy gets a data set of its own, <env>/<policy>-v0, as good as it plays; `--mixed` makes one of them all,
<env>/mixed-v0. All play the same rigs. Nothing is there before all is whole: after Ctrl-C the same command begins anew.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from agents.dataset.card import card
from agents.dataset.recipe import MIXED, Player, Recipe, find_players
from agents.dataset.recording import record
from agents.dataset.storage import DataSet, check_free, check_minari, minari_root
from agents.training.hyperparameters import read_pairs
from drillrig_env import __version__
from drillrig_env.command_line import Failed, Parser, command
from drillrig_env.files import check_writable, written_folders
from drillrig_env.flags import add_fields, given_fields
from drillrig_env.progress import Progress

COMMAND = "python -m agents.dataset"

_AT_ONCE = 250  # rigs that play side by side


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Record what the command line says."""
    parser = Parser(prog=COMMAND, description=__doc__)
    add_fields(parser, Recipe, skip=("env_kwargs",), flags={"env_id": ("--env",)})
    meaning = Recipe.__dataclass_fields__["env_kwargs"].metadata["meaning"]
    parser.add_argument("--env-kwargs", nargs="+", default=(), metavar="NAME:VALUE", help=meaning)
    chosen = parser.parse_args(arguments)
    line = shlex.join([*COMMAND.split(), *(sys.argv[1:] if arguments is None else arguments)])
    try:
        recipe = Recipe(**given_fields(chosen, Recipe) | {"env_kwargs": read_pairs(chosen.env_kwargs)})
        players = find_players(recipe)
        folders = free_folders(recipe, players)
    except (ValueError, ImportError, FileExistsError) as error:
        parser.error(error)
    try:
        make(recipe, players, folders, line)
    except KeyboardInterrupt as stop:
        stop.add_note("nothing was written; the same command begins anew")
        raise
    for name, folder in folders.items():
        print(f"{name}: {folder}")


def free_folders(recipe: Recipe, players: Sequence[Player]) -> dict[str, Path]:
    """The folders of a recipe's data sets by their ids.

    `OSError` where one is there that may not be overwritten or none can be written, `ImportError` without Minari.
    """
    check_minari()
    root = minari_root() if recipe.output is None else recipe.output.resolve()
    names = [MIXED] if recipe.mixed else [player.name for player in players]
    folders = {f"{recipe.env_id}/{name}-v0": root / recipe.env_id / f"{name}-v0" for name in names}
    if not recipe.overwrite:
        check_free(folders.values())
    for folder in folders.values():
        check_writable(folder)
    return folders


def make(recipe: Recipe, players: Sequence[Player], folders: Mapping[str, Path], line: str) -> None:
    """Record the episodes and write all data sets of a recipe, or none.

    `Failed` where a policy fails on the way, `FileExistsError` where another process has written one meanwhile.

    `line` is the command for the cards.
    """
    groups = [list(players)] if recipe.mixed else [[player] for player in players]
    recorded: dict[str, dict[str, np.ndarray]] = {}
    still_free = None if recipe.overwrite else partial(check_free, folders.values())
    with written_folders(list(folders.values()), still_free) as new:
        sets = []
        with Progress("data sets", len(players)) as progress:
            for name, folder, group in zip(folders, new, groups, strict=True):
                one = DataSet(folder, name, recipe.env_id, group[0].env_kwargs)
                sets.append(one)
                for player in group:
                    recorded[player.name] = _play(recipe, player, one, partial(progress.show, player.name))
        scale = _scale(recorded)
        for one, group in zip(sets, groups, strict=True):
            about = {
                "algorithm_name": ", ".join(player.name for player in group),
                "author": {"DrillRig"},
                "description": f"A drill string in stick-slip; {recipe.episodes} episodes a policy. See README.md.",
                "drillrig_version": __version__,
                "first_seed": recipe.first_seed,
                **scale,
            }
            one.finish(card(one.dataset_id, recipe, group, recorded, line, one.megabytes), about)


def _play(
    recipe: Recipe, player: Player, data_set: DataSet, show: Callable[[int, int], object]
) -> dict[str, np.ndarray]:
    """Let one policy play all its episodes into a data set; what is known of each of them.

    `show` is called with the control steps of all episodes that are done, and how many there are.
    """
    parts = []
    arguments = {**player.arguments, "threads": recipe.threads}
    for first in range(0, recipe.episodes, _AT_ONCE):
        rigs = min(_AT_ONCE, recipe.episodes - first)

        def tell(done: int, of: int, first: int = first, rigs: int = rigs) -> None:
            if done < of or first + rigs < recipe.episodes:  # the last ones are done when they are written
                show(first * of + rigs * done, recipe.episodes * of)

        try:
            recording = record(player.policy, arguments, recipe.first_seed + first, rigs, tell)
        except Exception as error:  # a stranger's policy may raise anything
            raise Failed(f"{player.name}: {type(error).__name__}: {error}") from error
        data_set.add(player.name, recording)
        parts.append(recording.about)
    show(recipe.episodes, recipe.episodes)
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _scale(recorded: Mapping[str, Mapping[str, np.ndarray]]) -> dict[str, float]:
    """What Minari's normalised score calls 0 and 1: the mean returns of the worst and the best policy recorded."""
    means = [float(about["return"].mean()) for about in recorded.values()]
    return {"ref_min_score": min(means), "ref_max_score": max(means)} if len(means) > 1 else {}


if __name__ == "__main__":
    raise SystemExit(main())
