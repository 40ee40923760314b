"""LQ feedback of the state that an ensemble of simulated rigs estimates from the sensors: a mark for what they tell."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from baselines.ensemble import CHANNELS, FORCE, MEMBERS, SIZE, TOLD, Ensemble
from baselines.lqr import LQR, FirmLQR
from drillrig_env.arrays import FloatArray
from drillrig_env.env.sensors import LONGEST_DELAY
from drillrig_env.model import STATE_NAMES
from drillrig_env.rig import RigLike

_STEPS, _PAST, _ENSEMBLE = LQR.memory, LQR.memory + 1, LQR.memory + 2 + LONGEST_DELAY
_LEAST_NOISE = 0.01  # of an exact channel, as a share of its scale
_TOGETHER = 128  # rigs whose members are simulated at once, so that they stay near the processor


class LQROnEnsemble(FirmLQR):
    """`LQR` on what an ensemble estimates; told the rig, the law of its friction and the delay, neither N_1 nor state.

    The ensemble (`baselines.ensemble`) follows the rig at the time of the last measurement; from there its mean is
    simulated on to the present, with the references of the steps since. Set point and feedback are those of `FirmLQR`.
    `threads` as for the batch core.

    Tuning rule: the ensemble's numbers were chosen among a few on a fleet to tune on.
    """

    channels: ClassVar[tuple[str, ...]] = ("speed_reference", "speed_target")
    any_of: ClassVar[tuple[tuple[str, ...], ...]] = (("bit_speed",), ("top_speed",), ("string_torque",), ("current",))
    privileged: ClassVar[tuple[str, ...]] = (*TOLD, "delay")
    exact: ClassVar[bool] = False
    slow: ClassVar[bool] = True
    memory: ClassVar[int] = _ENSEMBLE + MEMBERS * SIZE

    def __init__(
        self,
        sensors: str | tuple[str, ...] = "state",
        rig: RigLike = None,
        slew_limit: float | None = None,
        threads: int | None = None,
        **others: Any,
    ) -> None:
        super().__init__(sensors, rig, slew_limit, **others)
        noise = {
            channel.name: max(channel.noise, _LEAST_NOISE * channel.scale) / self.unit(channel.name)
            for channel in self.sensors.channels
            if channel.name in CHANNELS
        }
        friction, slew = self.nominal_friction, self.plant_slew
        self.ensemble = Ensemble(self.plants, self.plant, friction, slew, self.period, noise, threads)

    def desired_reference(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """What `LQR` wants where the state is the estimated one."""
        n = len(memory)
        places = np.broadcast_to(self.places(privileged), n)
        told: dict[str, FloatArray] = {name: np.broadcast_to(privileged[name], n) for name in self.privileged}
        told["rig"] = places.astype(float)
        mean = np.empty((n, SIZE))
        for some in np.array_split(np.arange(n), -(-n // _TOGETHER)):
            rows = memory[some]
            mean[some] = self._estimated(_of(seen, some), _of(told, some), rows)
            memory[some] = rows
        states = {name: mean[:, i] for i, name in enumerate(STATE_NAMES)}
        known = {**privileged, "normal_force": np.exp(mean[:, FORCE])}
        return super().desired_reference({**seen, **states}, known, memory[:, : LQR.memory])

    def _estimated(
        self, seen: Mapping[str, FloatArray], told: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """The mean member of the present, shape (n, SIZE); brings the memory of these rigs up to date."""
        n = len(memory)
        age, delay = memory[:, _STEPS].copy(), np.minimum(told["delay"].astype(int), LONGEST_DELAY)
        past = memory[:, _PAST:_ENSEMBLE]  # references, the present one first
        past[:, 1:] = past[:, :-1].copy()
        past[:, 0] = seen["speed_reference"]
        members = memory[:, _ENSEMBLE:].reshape(n, MEMBERS, SIZE)
        begins, comes = age == 0, age > delay  # until the second one comes, the first measurement is all that is seen
        if comes.any():
            stepped = self.ensemble.stepped(told, members, past[np.arange(n), delay])
            members[comes] = stepped[comes]
        if begins.any():
            members[begins] = self.ensemble.begun(_of(told, begins), past[begins, 0])
        measured = begins | comes
        if measured.any():
            members[measured] = self.ensemble.drawn_to(_of(seen, measured), members[measured])
        memory[:, _ENSEMBLE:] = members.reshape(n, -1)
        memory[:, _STEPS] += 1.0
        mean = members.mean(axis=1, keepdims=True)
        for ago in range(int(delay.max()), 0, -1):
            stepped = self.ensemble.stepped(told, mean, past[:, ago - 1])
            mean = np.where(((delay >= ago) & (age >= ago))[:, None, None], stepped, mean)
        return np.asarray(mean[:, 0])


def _of(values: Mapping[str, FloatArray], some: npt.NDArray[np.generic]) -> dict[str, FloatArray]:
    """What some rigs have of the values of all, by name."""
    return {name: value[some] for name, value in values.items()}
