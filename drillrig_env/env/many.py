"""What the forms with many rigs have in common: the batch core, a generator for each rig, states, and pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from drillrig_env.env.attributes import PlaysTask
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import EpisodeGenerators
from drillrig_env.env.state import EnvironmentState, checked_state
from drillrig_env.env.task import TaskLike

if TYPE_CHECKING:
    from drillrig_env.env.rendering import RigPictures


class ManyRigs(PlaysTask):
    """N rigs side by side, each with a generator, and a picture where they are rendered.

    A copy draws its own pictures, going on from what those of the original knew.
    """

    core: EpisodeBatch
    render_mode: str | None
    _generators: EpisodeGenerators
    _pictures: RigPictures | None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_pictures": self._memory()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._pictures = _pictures_of(self.core, self.render_mode)
        self._recall(state["_pictures"])

    def _make(
        self, num_envs: int, task: TaskLike, threads: int | None, render_mode: str | None, fields: dict[str, Any]
    ) -> None:
        """Make the rigs. Raises `ValueError` for an argument that is not allowed."""
        self.core = EpisodeBatch(num_envs, task, threads=threads, **fields)
        self.render_mode = render_mode
        self._generators = EpisodeGenerators(len(self.core))
        self.core.seeds = self._generators.seeds
        self._pictures = _pictures_of(self.core, render_mode)

    def get_state(self) -> EnvironmentState:
        """Everything that the coming steps depend on, the random generators included; see `DrillRigEnv.get_state`."""
        generators = {"generators": self._generators.states.copy(), "seeds": list(self._generators.seeds)}
        return self.core.get_state(self._form, **generators, picture=self._memory(), **self._own_state())

    def set_state(self, state: EnvironmentState) -> None:
        """Go on from a state that `get_state` gave, here or in another environment of the same task and size.

        Raises `ValueError` for a state of another task, number of rigs or form.
        """
        own = checked_state(state, self._form).own
        self.core.set_state(state)
        self._generators.states[:], self._generators.seeds[:] = own["generators"], own["seeds"]
        self._recall(own["picture"])
        self._take_own_state(own)

    @property
    def _form(self) -> str:
        """What a state is a state of."""
        return type(self).__name__

    def _own_state(self) -> dict[str, Any]:
        """What this form alone adds to a state."""
        return {}

    def _take_own_state(self, own: Any) -> None:
        """Take what this form alone has added to a state."""

    def _advance(self, rates: npt.NDArray[np.float32]) -> None:
        """Take all rigs through a control step; `rates` as `check_actions` gives them."""
        self.core.step(rates)
        if self._pictures is not None:
            self._pictures.follow()

    def _begin(self, rigs: npt.NDArray[np.intp], pins: dict[str, Any] | None = None) -> None:
        """Begin an episode in the rigs of these numbers, if any; `pins` is what it would draw otherwise."""
        if len(rigs) == 0:
            return
        self.core.reset(rigs, self._generators.uniforms(rigs), pins)
        if self._pictures is not None:
            self._pictures.begin(rigs)

    def _memory(self) -> list[Any] | None:
        """What the pictures know beyond the rigs' records; None where there are none."""
        return None if self._pictures is None else self._pictures.memory()

    def _recall(self, memory: list[Any] | None) -> None:
        """Go on from what other pictures knew, where there are some here and there were some there."""
        if self._pictures is not None and memory is not None:
            self._pictures.recall(memory)


def _pictures_of(core: EpisodeBatch, render_mode: str | None) -> RigPictures | None:
    """The pictures of a batch that is rendered. `ValueError` for an unknown mode."""
    if render_mode is None:
        return None
    if render_mode != "rgb_array":
        raise ValueError(f"render_mode = {render_mode!r} is not known for many rigs; allowed: None, rgb_array")
    from drillrig_env.env.rendering import RigPictures

    return RigPictures(core.task, core.episodes)
