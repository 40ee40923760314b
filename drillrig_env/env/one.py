"""What the form with one rig is beyond its steps: the batch core with one rig, states, copies, and a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium.error import ResetNeeded

from drillrig_env.arrays import Quantity
from drillrig_env.env.attributes import GymnasiumForm, set_for_all
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.info import entries_of, own_places
from drillrig_env.env.privileged import PRIVILEGED, Seen
from drillrig_env.env.state import EnvironmentState, checked_state
from drillrig_env.env.task import TaskLike
from drillrig_env.policy.given import POLICY

if TYPE_CHECKING:
    from drillrig_env.env.rendering import RigPicture

_BOUND = (
    "_advance",
    "_bank",
    "_rewarded",
    "_course",
    "_own",
    "_seen",
    "_shown",
    "_show",
    "_numbers",
    "_counts",
    "_picture",
)
"""What only holds for the arrays of this very one."""


class OneRig(GymnasiumForm, gym.Env[Seen, npt.NDArray[np.float32]]):
    """One rig, which `render_mode` has drawn: "rgb_array" as frames, "human" in a window.

    What the arrays of its batch hold is bound to its steps: a copy is bound to its own.
    """

    metadata: ClassVar[dict[str, Any]] = {  # type: ignore[misc]
        "render_modes": ["rgb_array", "human"],
        "render_fps": 10,  # of the chapter's rig
    }
    _picture: RigPicture | None

    def __init__(self, task: TaskLike, render_mode: str | None, fields: dict[str, Any]) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            allowed = ", ".join(self.metadata["render_modes"])
            raise ValueError(f"render_mode = {render_mode!r} is not known; allowed: None, {allowed}")
        self.core = EpisodeBatch(1, task, threads=1, **fields)
        self.render_mode = render_mode
        self._action = np.zeros((1, 1), dtype=np.float32)
        self._steps, self._info = self.core.steps, dict[str, Any]()
        self.metadata = {**self.metadata, "render_fps": self._frame_rate}  # type: ignore[misc]
        self._bind()

    def __getstate__(self) -> dict[str, Any]:
        self.core.observations = self._seen[None].copy()
        state = {name: value for name, value in self.__dict__.items() if name not in _BOUND}
        if self.render_mode == "human":  # there is one window, and it is not the copy's
            return {**state, "render_mode": None}
        return {**state, "_memory": self._memory()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        memory = state.pop("_memory", None)
        self.__dict__.update(state)
        self._bind()
        self._seen[:] = self.core.observations[0]
        self._recall(memory)

    def _bind(self) -> None:
        """Make what stands on the arrays of this very environment; a copy has others."""
        self._seen = np.zeros(len(self.sensors.channels), dtype=np.float32)
        self._shown = np.zeros((1, len(self.privileged_channels)), dtype=np.float32)
        self._bind_step()
        record = self.core.episodes[0]
        self._numbers, self._counts = entries_of(record)
        self._picture = None if self.render_mode is None else self._new_picture(record)

    def _bind_step(self) -> None:
        """Make the call of a control step."""
        self._advance = self.core.bound_step(self._action, self._seen[None])
        self._show = self.core.bound_show(self._shown)
        self._bank, self._rewarded, self._course = self.core.bank, self.reward, self.core.course
        self._own = own_places(self.reward, self.scenario)

    def change(self, **fields: Any) -> None:
        """Give `scenario`, `reward` or `slew_limit` another value; see `PlaysTask.change`."""
        super().change(**fields)
        self._follow()
        self._keep_info()

    def set_target(self, speed_target: Quantity) -> None:
        """Ask for another speed (rad/s) from now on; see `PlaysTask.set_target`."""
        super().set_target(speed_target)
        self._keep_info()

    def _follow(self) -> None:
        """Step with the rigs, the reward and the course that there are now."""
        now = self.core.bank is self._bank and self.reward is self._rewarded and self.core.course is self._course
        if not now:
            self._bind_step()

    def get_state(self) -> EnvironmentState:
        """Everything that the coming steps depend on, the random generator included; `set_state` comes back to it."""
        generator = None if self._np_random is None else self._np_random.bit_generator.state
        own = {"generator": generator, "seed": self._np_random_seed, "picture": self._memory()}
        self.core.observations = self._seen[None].copy()
        return self.core.get_state(type(self).__name__, **own)

    def set_state(self, state: EnvironmentState) -> None:
        """Go on from a state that `get_state` gave, here or in another environment of the same task.

        Raises `ValueError` for a state of another task or form.
        """
        own = checked_state(state, type(self).__name__).own
        self.core.set_state(state)
        self._follow()
        self._seen[:] = self.core.observations[0]
        if own["generator"] is None:
            self._np_random = None
        else:
            self.np_random.bit_generator.state = own["generator"]
        self._np_random_seed = own["seed"]
        self.core.seeds = (own["seed"],)
        self._recall(own["picture"])
        self._keep_info()

    def _seen_by_both(self) -> Seen:
        """What the policy and its critic see now."""
        if self._show is not None:
            self._show()
        return {POLICY: self._seen.copy(), PRIVILEGED: self._shown[0].copy()}

    def _keep_info(self) -> None:
        """Keep what every info of the episode says alike; making numbers costs more than the physics of a step."""
        self._info = {name: values[0] for name, values in self.core.info().items()}

    def set_wrapper_attr(self, name: str, value: Any, *, force: bool = True) -> bool:
        """Set an attribute as wrappers and the vector environments of Gymnasium ask for it; `scenario`, for example.

        Returns False, and leaves it to the wrapper, where there is no attribute of this name and `force` is false.
        Raises `AttributeError` for what cannot be changed (see `change`) and `ValueError` for a value that is not
        allowed.
        """
        if not (force or hasattr(self, name)):
            return False
        set_for_all(self, name, value)
        return True

    def render(self) -> npt.NDArray[np.uint8] | None:
        """The rig as RGB of shape (540, 960, 3) in the mode "rgb_array"; otherwise None.

        In the mode "human" `reset` and `step` show the rig by themselves. Raises `ResetNeeded` before
        the first episode.
        """
        if self._picture is None:
            gym.logger.warn(
                "render() does nothing without a render_mode; name one when the environment is made, "
                'for example gym.make("DrillRig-v0", render_mode="rgb_array")'
            )
            return None
        if not self._picture.began:
            raise ResetNeeded("there is no episode to draw yet; call reset() first")
        if self.render_mode == "rgb_array":
            return self._picture.frame()
        self._picture.show()
        return None

    def close(self) -> None:
        """Close the window of the mode "human"."""
        if self._picture is not None:
            self._picture.close()

    def _memory(self) -> Any:
        """What the picture knows beyond the rig's record; None where there is no picture."""
        return None if self._picture is None else self._picture.memory()

    def _recall(self, memory: Any) -> None:
        """Go on from what another picture knew, where there is one here and there was one there."""
        if self._picture is not None and memory is not None:
            self._picture.recall(memory)

    def _new_picture(self, record: np.void) -> RigPicture:
        from drillrig_env.env.rendering import RigPicture

        return RigPicture(self.core.task, record, self.render_mode == "human", self._frame_rate)
