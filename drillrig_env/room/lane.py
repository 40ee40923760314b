"""A lane: one rig in the environment's own batch core, its policy, and the operator's hand on its speed reference."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from drillrig_env.allowed import Allowed
from drillrig_env.arrays import FloatArray
from drillrig_env.course import COLUMNS
from drillrig_env.env.actions import check_actions, rate_action
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.kernel import scratch
from drillrig_env.env.task import Task
from drillrig_env.parameters import checked
from drillrig_env.policy import Policy, privileged_of
from drillrig_env.policy.contract import Memory
from drillrig_env.room.between import Between
from drillrig_env.room.strangers import named
from drillrig_env.room.verdicts import RunningVerdict, Verdict
from drillrig_env.stepper.ladder import SAMPLES

SIGNALS = ("bit_speed", "collar_speed", "top_speed", "twist_12", "twist_23", "torque_into_string", "current")
"""What is shown of every lane, SAMPLES times a control step."""

SIGNAL_UNITS = ("rad/s", "rad/s", "rad/s", "rad", "rad", "N m", "A")

STEP_VALUES = ("speed_reference", "action", "by_hand", "reward_variance", "reward_tracking", "reward_action", "voltage")
"""What is shown of every lane once a control step."""

_ONLY = np.zeros(1, dtype=np.intp)
_TARGET = COLUMNS.index("speed_target")


@dataclass(eq=False)
class Shown:
    """What a control step of a lane shows: SIGNALS of shape (7, SAMPLES) and STEP_VALUES of shape (7,).

    `seen` has what the policy will see next, channel by channel in its unit, and `verdict` is that at the step's end.
    """

    signals: npt.NDArray[np.float32]
    values: npt.NDArray[np.float32]
    seen: npt.NDArray[np.float32]
    verdict: Verdict


class Lane:
    """One rig and who controls it. `task` has a scenario with a course that gives everything.

    The episode is the one that the environment begins with `reset(seed=seed, options={"start": start})`.
    """

    def __init__(self, task: Task, policy: Policy, name: str, seed: int, start: str) -> None:
        self.task, self.name = task, name
        self.core = EpisodeBatch(1, task, threads=1)
        self.core.reset(_ONLY, first_uniforms(seed, 1), {"start": start})
        self.hand: float | None = None  # rad/s, the speed reference that the operator asks for; None: the policy's
        self.verdict = RunningVerdict(task)
        self.action = 0.0
        self._policy, self._told = policy, privileged_of(policy)
        self._state: Memory = None
        self._begins = np.ones(1, dtype=np.bool_)
        self._actions = np.zeros((1, 1), dtype=np.float32)
        self._seen = self.core.observations.copy()
        self._memory, self._between = scratch(), Between(task)
        self._advance = self.core.bound_step(self._actions, self._seen, self._memory)
        self._references = Allowed(0.0, task.largest_reference)

    @property
    def episode(self) -> np.ndarray:
        """The record of the episode, one of EPISODE."""
        record: np.ndarray = self.core.episodes[0]
        return record

    @property
    def speed_reference(self) -> float:
        """The speed reference of the last control step, rad/s."""
        return float(self.core.episodes["speed_reference"][0])

    @property
    def seen(self) -> FloatArray:
        """The channels that the policy saw last, as physical values in their units."""
        target = float(self.core.episodes["speed_target"][0])
        return np.array([float(value) for value in self.task.sensors.values(self._seen[0], target).values()])

    def take(self, reference: float | str | None) -> None:
        """Take the lane over at a speed reference (rad/s), or give it back (None); either way nothing jumps.

        The reference goes to where it is asked for no faster than the slew limit. Taken over without a reference of
        one's own, at the one that there is. `ValueError` for a reference that is not allowed.
        """
        if reference is not None:
            reference = float(checked("control room", "speed_reference", reference, "rad/s", self._references))
        self.hand = reference

    def step(self, row: FloatArray) -> Shown:
        """One control step with what `row` gives (see `drillrig_env.room.given`).

        The policy is asked in every step, so that it knows the rig when it is given back. Raises `ValueError` for
        whatever the policy raises and for an action that is none, and `NotFiniteError` for a state that is lost.
        """
        episode = self.core.episodes
        with named(f"the policy of lane {self.name}"):
            if self._told:
                self._policy.tell(self.core.info())  # type: ignore[attr-defined]
            seen = self._seen.copy()
            actions, self._state = self._policy.predict(seen, self._state, self._begins, deterministic=True)
            rates = check_actions(actions, 1)
        self._begins = np.zeros(1, dtype=np.bool_)
        if self.hand is not None:
            wanted = np.array([self.hand])
            rates = rate_action(wanted, episode["speed_reference"], self.task.slew_limit, self.task.control_period)
        np.clip(rates, -1.0, 1.0, out=self._actions)
        self.action = float(self._actions[0, 0])
        self.core.course[int(episode["step"][0])] = row
        before = episode["state"][0, :7].copy()
        if self._advance():
            self.core.refuse_lost()
        record = episode[0]
        self.verdict.add(record["lowest"], record["highest"], record["average"], record["stuck"])
        return self._shown(record, before, float(row[_TARGET]))

    def _shown(self, record: np.void, before: FloatArray, target: float) -> Shown:
        work = self._memory["work"][0]
        speeds = work["speed_samples"][:SAMPLES]
        states = self._between.states(before, record["state"][:7], speeds, record["speed_reference"])
        signals = np.empty((len(SIGNALS), SAMPLES), dtype=np.float32)
        signals[0], signals[1], signals[2] = speeds, states[3], states[4]
        signals[3], signals[4] = states[0], states[1]
        signals[5], signals[6] = work["torque_samples"][:SAMPLES], states[5]
        by_hand = float(self.hand is not None)
        values = (record["speed_reference"], self.action, by_hand, *record["terms"], record["voltage"])
        seen = self.seen.astype(np.float32)
        return Shown(signals, np.array(values, dtype=np.float32), seen, self.verdict.now(target))
