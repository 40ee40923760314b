"""An exported agent as it runs without PyTorch: measured values by name in, rates of the speed reference out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from drillrig_env.extras import missing

_TYPES = {"tensor(double)": np.float64, "tensor(float)": np.float32}


class ExportedPolicy:
    """The policy in an ONNX file that `agents.shipping.export` wrote; it keeps its own memory.

    Values may be of any kind of number: the file wants float64, and whatever stands in between (a normalising
    wrapper, a driver of measuring hardware) may give float32.
    """

    def __init__(self, path: str | Path) -> None:
        try:
            import onnxruntime
        except ImportError as error:
            raise missing("an exported agent", "onnxruntime", "export") from error
        self._session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
        self._remembered = {output.name for output in self._session.get_outputs()[1:]}
        self._inputs = {item.name: item for item in self._session.get_inputs()}
        self._memory: dict[str, npt.NDArray[np.float32]] = {}

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured values that it wants."""
        return tuple(name for name in self._inputs if f"next_{name}" not in self._remembered)

    def reset(self) -> None:
        """Forget what was seen: an episode begins."""
        self._memory = {}

    def rates(self, values: Mapping[str, npt.ArrayLike]) -> npt.NDArray[np.float32]:
        """Rates of the speed reference (rad/s^2), shape (n, 1), for n rigs.

        `values` holds, by channel, physical values in the units of the file's metadata, of shape (n,) or (n, 1).
        Raises `ValueError` for a channel that is missing.
        """
        lacking = [name for name in self.channels if name not in values]
        if lacking:
            raise ValueError(f"the exported agent wants the channels {', '.join(lacking)} too")
        given = {name: self._as_wanted(name, values[name]) for name in self.channels}
        rigs = len(next(iter(given.values())))
        memory = self._memory or {
            name: np.zeros((rigs, item.shape[1]), np.float32)
            for name, item in self._inputs.items()
            if name not in self.channels
        }
        rates, *remembered = self._session.run(None, {**given, **memory})
        self._memory = dict(zip(memory, remembered, strict=True))
        found: npt.NDArray[np.float32] = rates
        return found

    def _as_wanted(self, name: str, value: npt.ArrayLike) -> npt.NDArray[np.floating]:
        """A column of numbers of the kind that the file has for this channel."""
        return np.asarray(value, dtype=_TYPES[self._inputs[name].type]).reshape(-1, 1)
