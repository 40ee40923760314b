"""Sampling predictive control, told everything: what is possible at all, as an upper mark.

Model predictive path integral control (Williams, Aldrich & Theodorou, J. Guid. Control Dyn. 40, 2017):
roll many perturbed plans out in the model, weigh each by its cost, and follow the weighted mean.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from baselines.counted import CountedLaw
from baselines.set_point_feedback import SIZE, SetPointFeedback, wanted_change
from drillrig_env.arrays import FloatArray
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.episode import EPISODE
from drillrig_env.env.sensors import LONGEST_DELAY
from drillrig_env.friction import Friction
from drillrig_env.model import STATE_NAMES
from drillrig_env.parameters import refuse
from drillrig_env.rig import RigLike
from drillrig_env.scales import LARGEST_REFERENCE

KNOTS = 16
"""Knots of a plan; the set-point moves from one to the next in even steps of the feedback."""

INTERVAL = 2
"""Control steps from knot to knot, and from one planning to the next."""

HORIZON = (KNOTS - 1) * INTERVAL
"""Control steps of a rollout."""

_LOWEST = -1.5  # of a plan: a fifth of the target
_FLOOR = 0.1  # a bit slower than this share of the target costs no more
_NOISES = 32  # sets of perturbations, taken in turn
_KEPT = 0.7  # correlation of the perturbation from knot to knot
_EASING = (1.0, 2.0, 4.0, 8.0)  # s, from the present set-point to the target
_JUMPS = (4.0, 6.0, 8.0, LARGEST_REFERENCE)  # rad/s
_JUMP_SHAPES = ((1.0, 3.0), (1.0, 6.0), (3.0, 3.0), (3.0, 6.0))  # s of dwelling above, s of coming down


class MPPI(CountedLaw):
    """Plans of the set-point of a stabilising feedback, by rollouts in the batch core; told the friction.

    Law: omega_ref follows an LQ feedback about steady rotation at a set-point
    (`baselines.set_point_feedback`), and the set-point a plan: log(set-point / target) at KNOTS
    knots. Every INTERVAL steps each rig tries the last plan, shifted; plans that have a name (the
    target, below it, easing down to it in 1 to 8 s, jumps to 4 to 10 rad/s that are eased down); and
    `samples` random perturbations of the last plan, of standard deviations `spread` in turn. Each is
    rolled out over HORIZON steps with the feedback inside, from the state that the sensors show and under
    the same slew limit. A plan costs

        sum over its steps of [log(max(bit speed, 0.1 target) / target)]^2,

    in which standing still is dearer than turning too fast: with the square of the plain error a heavily
    loaded bit would rather stand than pass through speeds of several times its target. The new plan is
    the mean of all, with weights exp(-(cost - least cost) / (temperature least cost)).

    Told the friction and the present N_1, not a load that is still to come. Where `info` has the `delay`
    of the measurements, the state shown is first brought up to date in the batch core with the references
    of the steps since; noise is not filtered. The random numbers are the same for every rig and
    come from `seed`, so that a run repeats exactly, and a rig does the same in a batch as alone.
    `threads` as for the batch core. Raises `ValueError` for arguments that are not allowed.

    Source: Williams, Aldrich & Theodorou, "Model predictive path integral control: from theory to
    parallel computation", J. Guid. Control Dyn. 40 (2017). Tuning rule: no search. The cost, the horizon and
    the other numbers were chosen among a few on draws of the default scenario with seeds that no suite uses. More
    samples and shorter intervals cost time and bring the calm sooner; `samples=0` compares the plans that
    have a name. `effort` belongs to the feedback: with a small one it saturates and loses the rig from far away.
    """

    channels: ClassVar[tuple[str, ...]] = (
        *STATE_NAMES,
        "speed_reference",
        "speed_target",
        "bit_speed_mean",
        "bit_speed_deviation",
    )
    privileged: ClassVar[tuple[str, ...]] = ("normal_force", "mu_s", "mu_k", "v_b")
    memory = KNOTS + 1 + LONGEST_DELAY  # the plan, the control steps done, and the references before the present one
    slow: ClassVar[bool] = True

    def __init__(
        self,
        sensors: str | tuple[str, ...] = "state",
        rig: RigLike = None,
        slew_limit: float | None = None,
        samples: int = 32,
        temperature: float = 0.05,
        spread: tuple[float, ...] = (0.1, 0.3, 0.8),
        effort: float = 30.0,
        seed: int = 0,
        threads: int | None = None,
        **others: Any,
    ) -> None:
        super().__init__(sensors, rig, slew_limit, **others)
        self.check_chapters_law()
        if samples < 0:
            raise refuse("MPPI", "samples", samples, "", ">= 0")
        for name, value in (("temperature", temperature), ("effort", effort)):
            if not value > 0.0:
                raise refuse("MPPI", name, value, "", "> 0")
        self.temperature = temperature
        self.threads = threads
        self.feedback = SetPointFeedback([self.plant], effort, self.period)
        self._noises = _coloured(np.random.default_rng(seed), samples, spread)
        self._core: EpisodeBatch | None = None
        self._delay = np.zeros(1, dtype=int)

    def tell(self, info: Mapping[str, Any]) -> None:
        """Take the friction and, where `info` has it, the `delay` of the measurements in control steps."""
        super().tell(info)
        self._delay = np.atleast_1d(np.asarray(info.get("delay", 0), dtype=int))

    def desired_reference(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """Plan where it is time to, and follow the plan with the feedback."""
        rigs = self._records(seen, privileged)
        age = memory[:, KNOTS].astype(int)
        past = memory[:, KNOTS + 1 :]  # the last one first
        rigs = self._brought_up_to_date(rigs, past, np.minimum(self._delay, age))
        past[:, 1:] = past[:, :-1].copy()
        past[:, 0] = rigs["speed_reference"]
        due = np.flatnonzero(age % INTERVAL == 0)
        if len(due):
            last = memory[due, :KNOTS]
            memory[due, :KNOTS] = self._planned(rigs[due], last, age[due] // INTERVAL)
        memory[:, KNOTS] += 1
        ends = self._feedback(rigs, memory[:, None, :2])
        share = ((age % INTERVAL) / INTERVAL)[:, None]
        row = ends[:, 0, 0] + share * (ends[:, 0, 1] - ends[:, 0, 0])
        return rigs["speed_reference"] + wanted_change(row, rigs["state"], rigs["speed_reference"])

    def _records(self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray]) -> np.ndarray:
        """Records of the batch core, shape (n,), from what is seen and told."""
        rigs = np.zeros(len(seen["speed_target"]), dtype=EPISODE)
        for i, name in enumerate(STATE_NAMES):
            rigs["state"][:, i] = seen[name]
        for name in ("speed_reference", "speed_target"):
            rigs[name] = seen[name]
        rigs["mean"], rigs["variance"] = seen["bit_speed_mean"], seen["bit_speed_deviation"] ** 2
        for name in self.privileged:
            rigs[name] = privileged[name]
        rigs["load_times"] = rigs["target_time"] = np.inf
        return rigs

    def _brought_up_to_date(self, rigs: np.ndarray, past: FloatArray, late: np.ndarray) -> np.ndarray:
        """Records of now, from a state that is `late` control steps old and the references `past` since then."""
        references = np.column_stack([rigs["speed_reference"], past])  # the column k is that of k steps ago
        for ago in range(int(late.max()), 0, -1):
            some = np.flatnonzero(late >= ago)
            core = self._batch(len(some), int(late.max()))
            core.episodes[:] = rigs[some]
            core.episodes["speed_reference"] = references[some, ago]
            change = references[some, ago - 1] - references[some, ago]
            core.step((change / (self.plant_slew * self.period)).astype(np.float32)[:, None])
            core.episodes["step"] = 0
            rigs[some] = core.episodes
        rigs["speed_reference"] = references[:, 0]
        return rigs

    def _planned(self, rigs: np.ndarray, last: FloatArray, turn: np.ndarray) -> FloatArray:
        """New plans, shape (n, KNOTS), from the last ones and how often each rig has planned."""
        shifted = np.where(turn[:, None] > 0, np.column_stack([last[:, 1:], last[:, -1]]), last)
        base = shifted[:, None]
        highest = np.log(LARGEST_REFERENCE / rigs["speed_target"])[:, None, None]
        plans = np.concatenate(
            [base, _named(base[:, :, :1], rigs["speed_target"], self.period), base + self._noises[turn % _NOISES]], 1
        )
        plans = np.clip(plans, _LOWEST, highest)
        cost = self._cost(rigs, plans)
        least = cost.min(axis=1, keepdims=True)
        weight = np.exp((least - cost) / (self.temperature * least + 1e-9))
        weight /= weight.sum(axis=1, keepdims=True)
        return np.asarray((weight[:, :, None] * plans).sum(axis=1))

    def _cost(self, rigs: np.ndarray, plans: FloatArray) -> FloatArray:
        """Cost of plans of shape (n, plans, KNOTS), each rolled out from its rig; shape (n, plans)."""
        count = plans.shape[1]
        core = self._core
        if core is None or len(core) != plans[..., 0].size:
            core = self._core = self._batch(plans[..., 0].size, HORIZON)
        core.episodes[:] = np.repeat(rigs, count)
        target, slew = core.episodes["speed_target"].copy(), self.plant_slew * self.period
        cost = np.zeros(len(core))
        following = self._feedback(rigs, plans[:, :, :1]).reshape(-1, SIZE + 1)
        for knot in range(1, KNOTS):
            row, following = following, self._feedback(rigs, plans[:, :, knot : knot + 1]).reshape(-1, SIZE + 1)
            step = (following - row) / INTERVAL
            for _ in range(INTERVAL):
                change = wanted_change(row, core.episodes["state"], core.episodes["speed_reference"])
                core.step((change / slew).astype(np.float32)[:, None])
                cost += np.log(np.maximum(core.episodes["average"] / target, _FLOOR)) ** 2
                row = row + step
        return cost.reshape(-1, count)

    def _batch(self, rigs: int, steps: int) -> EpisodeBatch:
        """A batch core of the rig as it is counted here, whose episodes have so many control steps."""
        return EpisodeBatch(
            rigs,
            rig=self.plant,
            slew_limit=self.plant_slew,
            control_period=self.period,
            largest_reference=LARGEST_REFERENCE,
            duration=steps * self.period,
            threads=self.threads,
        )

    def _feedback(self, rigs: np.ndarray, plans: FloatArray) -> FloatArray:
        """The feedback at the knots of plans of shape (n, ...); shape (n, ..., SIZE + 1)."""
        each = (slice(None), *(None for _ in plans.shape[1:]))
        friction = Friction(*(rigs[name][each] for name in self.privileged))
        return self.feedback.at(friction, rigs["speed_target"][each] * np.exp(plans))


def _named(start: FloatArray, target: FloatArray, period: float) -> FloatArray:
    """Plans with a name: target, below it, hold, ease down, jump; `start` (n, 1, 1); shape (n, plans, KNOTS)."""
    times = np.arange(KNOTS) * INTERVAL * period
    ease = np.clip(1.0 - times / np.array(_EASING)[:, None], 0.0, 1.0)
    dwell, down = (np.array(each)[:, None] for each in zip(*_JUMP_SHAPES, strict=True))
    jump = np.clip((dwell + down - times) / down, 0.0, 1.0)
    heights = np.log(np.maximum(np.array(_JUMPS) / target[:, None], 1.0))
    jumps = (heights[:, :, None, None] * jump).reshape(len(target), -1, KNOTS)
    ones = np.ones((1, KNOTS))
    fixed = np.concatenate([0.0 * ones, np.log(0.8) * ones])
    return np.concatenate(
        [np.broadcast_to(fixed, (len(target), *fixed.shape)), start * np.concatenate([ones, ease]), jumps], axis=1
    )


def _coloured(generator: np.random.Generator, samples: int, spread: tuple[float, ...]) -> FloatArray:
    """Perturbations of shape (_NOISES, samples, KNOTS), correlated from knot to knot; `spread` in turn."""
    noise = generator.standard_normal((_NOISES, samples, KNOTS))
    for knot in range(1, KNOTS):
        noise[:, :, knot] = _KEPT * noise[:, :, knot - 1] + np.sqrt(1.0 - _KEPT**2) * noise[:, :, knot]
    return np.asarray(noise * np.resize(spread, samples)[:, None])
