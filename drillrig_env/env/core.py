"""The batch core: reset some rigs, step all rigs. The three forms of the environment stand on it."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.error import ResetNeeded

from drillrig_env.allowed import COUNT
from drillrig_env.arrays import FloatArray, Observations, Quantity
from drillrig_env.env.attributes import PlaysTask, check_changeable
from drillrig_env.env.bank import RigBank
from drillrig_env.env.draws import draw_episodes
from drillrig_env.env.episode import EPISODE
from drillrig_env.env.info import infos
from drillrig_env.env.kernel import observe_episodes, scratch, step_episodes
from drillrig_env.env.pins import check_pins
from drillrig_env.env.privileged import PRIVILEGED, Privileged, Seen
from drillrig_env.env.scenario import STARTS
from drillrig_env.env.settings import SETTINGS, course_of, write_settings
from drillrig_env.env.starts import begin_episodes
from drillrig_env.env.state import EnvironmentState
from drillrig_env.env.task import Task, TaskLike
from drillrig_env.friction import Friction
from drillrig_env.jit.compiled import bound
from drillrig_env.jit.threads import check_threads, over_slices
from drillrig_env.parameters import checked, refuse
from drillrig_env.policy.given import POLICY
from drillrig_env.stepper.finite import check_finite
from drillrig_env.verdict import CALM_INDEX, WINDOW, is_mitigated

_ALL = slice(None)


class EpisodeBatch(PlaysTask):
    """`num_rigs` rigs in their episodes: the rules of `DrillRig-v0`, in one place.

    `episodes` is an array of records (see `drillrig_env.env.episode.EPISODE`) with the state of every rig and
    what its last control step showed. Rigs share `task`, and each has its own friction and generator. The task may
    be given as a whole, by its fields, or both. `max_episode_steps` ends episodes before their `duration` does.
    It can be copied and pickled. Raises `ValueError` for an argument that is not allowed.
    """

    def __init__(
        self,
        num_rigs: int = 1,
        task: TaskLike = None,
        *,
        threads: int | None = None,
        max_episode_steps: int | None = None,
        **fields: Any,
    ) -> None:
        rigs = checked("DrillRig", "number of rigs", num_rigs, "", COUNT)
        self._task = Task.of(task, **fields)
        self.threads = check_threads(threads)
        self._steps = self._task.steps
        if max_episode_steps is not None:
            self._steps = min(self._steps, checked("DrillRig", "max_episode_steps", max_episode_steps, "", COUNT))
        self.episodes = np.zeros(rigs, dtype=EPISODE)
        self.episodes["step"] = self._steps  # no episode has begun
        self.seeds: Sequence[int | None] = ()  # of the rigs, where whoever resets them has any; for errors
        channels = len(self.sensors.channels)
        self.observations: Observations = np.zeros((rigs, channels), dtype=np.float32)
        longest = self._task.delays[1]
        self._past = np.zeros((rigs, longest + 1 if longest else 0, channels), dtype=np.float32)
        self._layout = self.sensors.layout(self.noise)
        self._settings = np.zeros(1, dtype=SETTINGS)
        self.course: FloatArray
        self._write_settings()
        self._bank = RigBank.of(self._task)
        self._order = np.arange(rigs)  # in which episodes are stepped; whichever it is, the same comes of it
        self.critic = Privileged(self._task, self._bank, rigs) if self._task.privileged else None

    def __len__(self) -> int:
        return len(self.episodes)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_bank": self._bank.guests}  # a copy makes its tables anew

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._bank = RigBank.of(self._task, state["_bank"])
        self._write_settings()  # a law of the user's own lies elsewhere in another process

    @property
    def rigs(self) -> np.ndarray:
        """The former name of `episodes`."""
        warnings.warn("`core.rigs` is now `core.episodes`", DeprecationWarning, stacklevel=2)
        return self.episodes

    @property
    def task(self) -> Task:
        """What is played."""
        return self._task

    def change(self, **fields: Any) -> None:
        """Give what is CHANGEABLE of the task another value; see `PlaysTask.change`."""
        check_changeable(fields)
        task, law = replace(self._task, **fields), self._task.scenario.friction.law
        if task.scenario.friction.law != law:
            allowed = f"{law!r}, that of the episodes under way; make an environment for another"
            raise refuse("DrillRig", "law of the scenario's friction", repr(task.scenario.friction.law), "", allowed)
        if task.delays[1] > (longest := max(0, self._past.shape[1] - 1)):
            allowed = f"0 to {longest}, that of the environment; make one for longer delays"
            raise refuse("DrillRig", "delay", task.delays[1], "control steps", allowed)
        if self.critic is not None:
            self.critic.check(task.scenario)
        bank, places = self._bank.moved(task, self.episodes["rig"][~self.ended])
        self._move(bank, places)
        self._play(task)

    @property
    def bank(self) -> RigBank:
        """The rigs that episodes have; others when a reset or `change` asks for others."""
        return self._bank

    @property
    def steps(self) -> int:
        """Control steps of an episode."""
        return self._steps

    @property
    def window_start(self) -> int:
        """The control step with which the window of the final verdict begins."""
        return max(0, self._steps - round(WINDOW * self._task.scales.time / self._task.control_period))

    @property
    def ended(self) -> npt.NDArray[np.bool_]:
        """Which episodes are over (or never began); shape (n,)."""
        return np.asarray(self.episodes["step"] >= self._steps)

    @property
    def mitigated(self) -> npt.NDArray[np.bool_]:
        """The verdict on the window so far: at the end of an episode, whether it was mitigated; shape (n,)."""
        return self.mitigated_below(CALM_INDEX)

    def mitigated_below(self, index: float) -> npt.NDArray[np.bool_]:
        """The same where a stick-slip index below `index` counts as calm."""
        done = np.maximum(self.episodes["step"] - self.window_start, 1)
        mean = self.episodes["window_sum"] / done
        lowest, highest, target = (self.episodes[name] for name in ("window_lowest", "window_highest", "speed_target"))
        return np.asarray(is_mitigated(lowest, highest, mean, target, self._speed_scale, index))

    def reset(
        self,
        indices: npt.NDArray[np.intp],
        uniforms: FloatArray,
        options: Mapping[str, Any] | None = None,
    ) -> None:
        """Begin a new episode in the rigs at `indices`, from the uniform numbers that it draws, (n, UNIFORMS).

        `options` pins what would be drawn, as numbers or with one entry for each of `indices`.
        Like `step` it leaves earlier `observations` as they were.
        """
        given = () if self.scenario.course is None else self.scenario.course.given
        pins = check_pins(options, len(indices), self.duration, self._task.targets, given)
        bank, places = self._bank, None
        if "rig" in pins:
            asked = bank.read(pins["rig"], len(indices))
            others = ~self.ended
            others[indices] = False
            bank, places = bank.moved(self._task, self.episodes["rig"][others], asked)
            pins["rig"] = bank.indices(asked)
        draws = draw_episodes(self.scenario, uniforms, self.duration, pins, bank.members.friction)
        fresh = begin_episodes(self._task, draws, self._settings, bank, self.threads)
        check_finite(fresh["state"][:, None, :7], np.zeros(1), "reset", indices, self.seeds)
        if places is not None:
            self._move(bank, places)
        self.episodes[indices] = fresh
        self._order_by_rig()
        seen = np.empty((len(indices), self.observations.shape[1]), dtype=np.float32)
        past = np.empty((len(indices), *self._past.shape[1:]), dtype=np.float32)
        observe_episodes(fresh, self._layout, past, seen, scratch())
        self._past[indices] = past
        self.observations = self.observations.copy()
        self.observations[indices] = seen
        self._show()

    def set_target(self, speed_target: Quantity) -> None:
        """Ask for another speed (rad/s) from now on, of all rigs or, as an array of shape (n,), of each by itself.

        The next observation shows it. A target step that is still to come comes, and the next episode draws its own
        target. Raises `ValueError` for a target that is not allowed, and where the scenario's course gives it, and
        `ResetNeeded` where none has begun.
        """
        if not self._task.targets.holds(speed_target):
            raise refuse("set_target", "speed_target", speed_target, "rad/s", self._task.targets)
        if np.shape(speed_target) not in ((), (len(self),)):
            raise refuse("set_target", "shape of speed_target", np.shape(speed_target), "", f"(), or ({len(self)},)")
        if self.scenario.course is not None and "speed_target" in self.scenario.course.given:
            raise ValueError("set_target: the scenario's course gives the target; give it no speed_target")
        if not self.episodes["speed_target"].all():
            raise ResetNeeded("set_target: no episode has begun; call reset() first")
        self.episodes["speed_target"] = speed_target

    def step(self, actions: npt.NDArray[np.float32]) -> None:
        """Step every rig whose episode is not over; `actions` of shape (n, 1), finite, clipped to +-1.

        `observations` is a new array after each step, so that earlier ones keep their values.
        """
        observations, own = np.empty_like(self.observations), self._task.reward.own
        moved = None if own is None or own.compiled else ~self.ended
        lost: list[int] = []

        def step(part: slice) -> None:
            lost.append(step_episodes(*self._arguments(part, actions, observations)))

        if self.threads == 1 or len(self.episodes) == 1:
            step(_ALL)
        else:
            over_slices(step, len(self.episodes), self.threads)
        if own is not None and moved is not None:
            lost.append(own.add_to(self.episodes, actions, moved))
        if any(lost):
            self.refuse_lost()
        self.observations = observations
        self._show()

    @property
    def seen(self) -> Seen:
        """What the rigs' environments show: `observations`, and beside them what a critic sees, if the task has one."""
        return self.observations if self.critic is None else {POLICY: self.observations, PRIVILEGED: self.critic.shown}

    def refuse_lost(self) -> None:
        """Raise `NotFiniteError` for the first rig whose state or reward is no longer finite after a control step."""
        times = self.control_period * self.episodes["step"][:, None]
        check_finite(self.episodes["state"][:, None, :7], times, "step", seeds=self.seeds)
        own = self._task.reward.own
        if own is not None:
            own.check_finite(self.episodes["own_terms"], times[:, 0], self.seeds)

    def bound_step(
        self,
        actions: npt.NDArray[np.float32],
        observations: Observations,
        memory: np.ndarray | None = None,
    ) -> Callable[[], int]:
        """A call that steps every rig, each time from and into these arrays, and leaves `self.observations` alone.

        For a single rig it is twice as fast as `step`, where finding the kernel takes longer than the physics.
        It is a call for this very batch: a copy needs one of its own. Where it returns more than 0, `refuse_lost`
        says why. `memory`, a record of SCRATCH as `scratch()` makes it, then holds the SAMPLES of bit speed and string
        torque within the step of the rig that was stepped last.
        """
        memory = scratch() if memory is None else memory
        advance = bound(step_episodes, *self._arguments(_ALL, actions, observations, memory))
        own = self._task.reward.own
        if own is None or own.compiled:
            return advance
        return lambda: advance() + own.add_to(self.episodes, actions)

    def bound_show(self, shown: Observations) -> Callable[[], None] | None:
        """A call that fills what a critic sees, `shown` (rigs, channels); None without one."""
        return None if self.critic is None else self.critic.bound_show(self.episodes, self._settings, shown)

    def get_state(self, form: str = "EpisodeBatch", **own: Any) -> EnvironmentState:
        """Everything that the coming steps depend on; `own` is what the form of the environment adds to it."""
        episodes, past, seen = self.episodes.copy(), self._past.copy(), self.observations.copy()
        return EnvironmentState(form, self._task, self._steps, episodes, past, seen, own, self._bank.guests)

    def set_state(self, state: EnvironmentState) -> None:
        """Go on from a state, of any form. Raises `ValueError` for one of another task, length or number of rigs."""
        state.check(self._task, self._steps, self.episodes, self._past)
        if self.critic is not None:
            self.critic.check(state.task.scenario)
        changed = state.task is not self._task
        if changed or state.guests != self._bank.guests:
            self._take(RigBank.of(state.task, state.guests))
        self.episodes[:] = state.episodes
        self._order_by_rig()
        self._past[:] = state.past
        self.observations = state.observations.copy()
        if changed:  # what is CHANGEABLE may differ
            self._play(state.task)
        self._show()

    @property
    def friction(self) -> Friction:
        """The friction of all rigs as it is now, a batch that stays as it is."""
        columns = (self.episodes[name].copy() for name in ("normal_force", "mu_s", "mu_k", "v_b"))
        return Friction(*columns, law=self._task.scenario.friction.law)

    def info(self) -> dict[str, npt.NDArray[Any]]:
        """What every step reports, by name, one entry a rig: always the same names with the same dtypes."""
        success = self.ended
        return infos(self.episodes, self.reward, success & self.mitigated if success.any() else success)

    def starts(self, indices: npt.NDArray[np.intp]) -> list[str]:
        """How the episodes of some rigs began: stick_slip only where their parameters have it."""
        return [STARTS[i] for i in self.episodes["start"][indices]]

    def _move(self, bank: RigBank, places: npt.NDArray[np.intp]) -> None:
        """Take another bank, in which each rig is at a place of its own."""
        if bank is not self._bank:
            self._take(bank)
            self.episodes["rig"] = places[self.episodes["rig"]]

    def _take(self, bank: RigBank) -> None:
        """Take another bank. `ValueError`, and nothing changes, where a critic does not see what its rigs differ in."""
        if self.critic is not None:
            self.critic.take(bank)
        self._bank = bank

    def _show(self) -> None:
        """Let a critic, if there is one, see the episodes as they are."""
        if self.critic is not None:
            self.critic.show(self.episodes, self._settings)

    def _order_by_rig(self) -> None:
        """Step the episodes of each rig one after the other."""
        if len(self._bank.rigs) > 1:
            self._order[:] = np.argsort(self.episodes["rig"])

    def _play(self, task: Task) -> None:
        """Play another task from now on, for which the arrays are made; whoever steps has them."""
        self._task = task
        self._layout[:] = self.sensors.layout(self.noise)
        self._write_settings()

    def _write_settings(self) -> None:
        """Write the numbers that the kernels need into the array that they already have."""
        write_settings(self._settings, self._task, self._steps, self.window_start)
        self._speed_scale, self.course = self._task.scales.speed, course_of(self._task, self._steps)

    def _arguments(
        self,
        part: slice,
        actions: npt.NDArray[np.float32],
        observations: Observations,
        memory: np.ndarray | None = None,
    ) -> tuple[Any, ...]:
        tables = self._bank.tables
        return (
            self._order[part],
            self.episodes,
            actions,
            self._settings,
            self._bank.plants,
            tables.ladders,
            self.course,
            self._layout,
            self._past,
            observations,
            scratch() if memory is None else memory,
        )
