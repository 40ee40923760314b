"""A policy's file as it runs, with NumPy and onnxruntime alone: values by name in, the speed reference out."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.deploy.about import check_digest, read_properties
from drillrig_env.extras import missing
from drillrig_env.parameters import closest

SHIPPED = Path(__file__).with_name("shipped")
"""Files of the policies that come with the package."""

_TYPES = {"tensor(double)": np.float64, "tensor(float)": np.float32}
_RATE, _REFERENCE = "speed_reference_rate", "next_speed_reference"


def shipped_policies() -> list[str]:
    """The names of the policies that come with the package as files.

    >>> from drillrig_env.deploy import shipped_policies
    >>> "lqg" in shipped_policies()
    True
    """
    return sorted(path.stem for path in SHIPPED.glob("*.onnx"))


def find_file(policy: str | Path) -> Path:
    """The file of a shipped policy by name, or the path itself. `ValueError` where there is neither."""
    for path in (SHIPPED / f"{policy}.onnx", Path(policy)):
        if path.is_file():
            return path
    known = closest(str(policy), [*shipped_policies(), "a file"])
    made = "" if known.startswith("did") else "; `python -m agents.export NAME` writes a file of a trained agent"
    raise ValueError(f"policy {str(policy)!r} is not known; {known}{made}")


class PolicyFile:
    """The policy in an ONNX file that `drillrig export` wrote, for any number of rigs; it keeps its own memory.

    `policy` is the name of a shipped one or a path. `about` holds what the file says: channels, control period, slew
    limit, drive, rig, training and so on (docs/hardware.md). Values may be of any kind of number. Raises `ValueError`
    for a file that is damaged or not such a policy, and `ImportError` without onnxruntime.

    >>> from drillrig_env.deploy import PolicyFile
    >>> PolicyFile("z_torque").inputs[:2]
    ('top_speed', 'current')
    """

    def __init__(self, policy: str | Path) -> None:
        try:
            import onnxruntime
        except ImportError as error:
            raise missing("a policy's file", "onnxruntime", "deploy") from error
        self.path = find_file(policy)
        content, options = self.path.read_bytes(), onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1  # a step is too small to be shared
        try:
            session = onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
        except Exception as error:  # onnxruntime has no error of its own in common
            raise ValueError(f"{self.path} is no ONNX file that can be run: {str(error).splitlines()[0]}") from error
        self.about: dict[str, Any] = read_properties(str(self.path), session.get_modelmeta().custom_metadata_map)
        check_digest(str(self.path), content, self.about["digest"])
        self.sha256 = hashlib.sha256(content).hexdigest()
        self._session = session
        self._kinds = {item.name: _TYPES[item.type] for item in session.get_inputs()}
        self._widths = {one["name"]: int(one["width"]) for one in self.about["memory"]}
        self._outputs = [_RATE, _REFERENCE, *(f"next_{name}" for name in self._widths)]
        self._memory: dict[str, npt.NDArray[Any]] = {}
        self._fed: dict[str, npt.NDArray[Any]] = {}

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the values that it wants."""
        return tuple(name for name in self._kinds if name not in self._widths)

    def reset(self) -> None:
        """Forget what was seen: an episode begins."""
        self._memory = {}

    def rehearse(self) -> None:
        """Compute the last step once more and forget it: the next one finds its numbers near the processor."""
        if self._fed:
            self._session.run(self._outputs, self._fed)

    def step(self, values: Mapping[str, npt.ArrayLike]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Rates (rad/s^2) and next values (rad/s) of the speed references of n rigs, shape (n,) each.

        `values` holds, by name, physical values in the units of `about`, of shape (), (n,) or (n, 1). Raises
        `ValueError` for one that is missing or not finite, and for numbers of rigs that differ.
        """
        given = {name: self._read(name, values) for name in self.inputs}
        rigs = {len(value) for value in given.values()}
        if self._memory:
            rigs.add(len(next(iter(self._memory.values()))))
        if len(rigs) > 1:
            raise ValueError(f"{self.path.stem}: values of {sorted(rigs)} rigs; allowed: one number of rigs")
        memory = self._memory or {
            name: np.zeros((max(rigs), width), self._kinds[name]) for name, width in self._widths.items()
        }
        self._fed = {**given, **memory}
        rates, references, *remembered = self._session.run(self._outputs, self._fed)
        self._memory = dict(zip(memory, remembered, strict=True))
        return rates[:, 0], references[:, 0]

    def _read(self, name: str, values: Mapping[str, npt.ArrayLike]) -> npt.NDArray[Any]:
        """A column of numbers of the kind that the file has for this input."""
        if name not in values:
            raise ValueError(f"{self.path.stem} wants {name} too; it wants {', '.join(self.inputs)}")
        value = values[name]
        if type(value) is float and isfinite(value):  # the common case, at a third of the time
            return np.full((1, 1), value, self._kinds[name])
        found = np.asarray(value, dtype=self._kinds[name]).reshape(-1, 1)
        if not np.all(np.isfinite(found)):
            raise ValueError(f"{self.path.stem}: {name} = {found[~np.isfinite(found)][0]} is not a finite number")
        return found
