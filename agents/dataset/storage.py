"""Data sets on disk, in Minari's format: whole or not there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

from agents.dataset.recording import ABOUT, Recording
from drillrig_env.extras import missing

CARD = "README.md"
_DATA = "data"  # where Minari looks for it in a data set's folder


def check_minari() -> None:
    """Raise `ImportError` that says what to install where Minari is not."""
    try:
        import h5py  # noqa: F401
        import minari  # noqa: F401
    except ImportError as error:
        raise missing("a data set", "minari and h5py", "clients") from error


def minari_root() -> Path:
    """The folder in which Minari looks for data sets."""
    from minari.storage import get_dataset_path

    return Path(get_dataset_path())


def check_free(folders: Iterable[Path]) -> None:
    """Raise `FileExistsError` that says what to do where one of the folders is there."""
    for folder in folders:
        if folder.exists():
            raise FileExistsError(f"{folder} is there already; remove it, choose another --output, or give --overwrite")


class DataSet:
    """A new data set in `folder`, which Minari reads as `dataset_id`.

    `env_id` and `env_kwargs` are the environment that `recover_environment()` is to give.
    """

    def __init__(self, folder: Path, dataset_id: str, env_id: str, env_kwargs: Mapping[str, Any]) -> None:
        from minari.dataset.minari_storage import MinariStorage

        env = gym.make(f"drillrig_env:{env_id}", **env_kwargs)
        self.folder, self.dataset_id = folder, dataset_id
        # Minari finds the size of its files by absolute paths only.
        self._storage = MinariStorage.new(
            folder.absolute() / _DATA,
            observation_space=env.observation_space,
            action_space=env.action_space,
            env_spec=env.spec,
        )

    def add(self, policy: str, recording: Recording) -> None:
        """Put a policy's episodes behind those that are there."""
        first = self._storage.total_episodes
        self._storage.update_episodes(_buffers(recording))
        about = [
            {"policy": policy, **{name: _plain(recording.about[name][i]) for name in ABOUT if name in recording.about}}
            for i in range(len(recording))
        ]
        self._storage.update_episode_metadata(about, range(first, first + len(recording)))

    def finish(self, card: str, about: Mapping[str, Any]) -> None:
        """Write the card, and what Minari is to know of the whole beside what it counts itself."""
        from minari import __version__

        self._storage.update_metadata({"dataset_id": self.dataset_id, "minari_version": __version__, **about})
        (self.folder / CARD).write_text(card, encoding="utf-8", newline="\n")

    @property
    def megabytes(self) -> float:
        """The size of its files."""
        return sum(path.stat().st_size for path in self.folder.rglob("*") if path.is_file()) / 1e6


def _buffers(recording: Recording) -> Iterator[Any]:
    from minari.data_collector import EpisodeBuffer

    steps = recording.rewards.shape[1]
    never, at_the_end = np.zeros(steps, dtype=np.bool_), np.arange(steps) == steps - 1
    for i in range(len(recording)):
        yield EpisodeBuffer(
            seed=int(recording.about["seed"][i]),
            observations=recording.observations[i],
            actions=recording.actions[i],
            rewards=recording.rewards[i],
            terminations=never,
            truncations=at_the_end,
            infos={name: values[i] for name, values in recording.infos.items()},
        )


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value
