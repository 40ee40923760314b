"""Types of arrays, as the whole project names them."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

FloatArray: TypeAlias = npt.NDArray[np.float64]

Quantity: TypeAlias = float | FloatArray
"""A number, or an array with one entry a rig."""

Observations: TypeAlias = npt.NDArray[np.float32]
"""Observations, shape (n, channels)."""

Actions: TypeAlias = npt.NDArray[np.float32]
"""Actions, shape (n, 1)."""

Record: TypeAlias = Any
"""A structured NumPy scalar inside a kernel: its fields are attributes there, which no static type knows."""

Records: TypeAlias = Any
"""An array of records, inside a kernel or on the way to one."""
