"""ONNX graphs in the making: values that can be reckoned with as NumPy's, operators by name, memory.

    graph = Graph()
    speed = graph.input("top_speed")
    graph.output("twice", 2.0 * speed)

Every value has a row for each rig. All numbers are doubles unless a network asks for less.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
import onnx
from onnx import TensorProto, helper, numpy_helper
from scipy.interpolate import CubicSpline

OPSET, IR_VERSION = 17, 8
"""Both widely understood by runtimes."""

NEXT = "next_"
"""What the name of a memory's output begins with: what comes out there goes in at the next control step."""

_TYPES: dict[Any, int] = {
    np.float64: TensorProto.DOUBLE,
    np.float32: TensorProto.FLOAT,
    np.int64: TensorProto.INT64,
}

Operand: TypeAlias = "Value | float | npt.NDArray[Any]"


class Value:
    """A tensor of a graph; arithmetic and comparisons with others and with numbers make operators."""

    __hash__ = None  # type: ignore[assignment]
    __array_ufunc__ = None  # NumPy's numbers leave it to the operators below

    def __init__(self, graph: Graph, name: str) -> None:
        self.graph, self.name = graph, name

    def __add__(self, other: Operand) -> Value:
        return self.graph.make("Add", self, other)

    def __radd__(self, other: Operand) -> Value:
        return self.graph.make("Add", other, self)

    def __sub__(self, other: Operand) -> Value:
        return self.graph.make("Sub", self, other)

    def __rsub__(self, other: Operand) -> Value:
        return self.graph.make("Sub", other, self)

    def __mul__(self, other: Operand) -> Value:
        return self.graph.make("Mul", self, other)

    def __rmul__(self, other: Operand) -> Value:
        return self.graph.make("Mul", other, self)

    def __truediv__(self, other: Operand) -> Value:
        return self.graph.make("Div", self, other)

    def __rtruediv__(self, other: Operand) -> Value:
        return self.graph.make("Div", other, self)

    def __neg__(self) -> Value:
        return self.graph.make("Neg", self)

    def __lt__(self, other: Operand) -> Value:  # type: ignore[misc]
        return self.graph.make("Less", self, other)

    def __le__(self, other: Operand) -> Value:  # type: ignore[misc]
        return self.graph.make("LessOrEqual", self, other)

    def __gt__(self, other: Operand) -> Value:  # type: ignore[misc]
        return self.graph.make("Greater", self, other)

    def __ge__(self, other: Operand) -> Value:  # type: ignore[misc]
        return self.graph.make("GreaterOrEqual", self, other)

    def __and__(self, other: Value) -> Value:
        return self.graph.make("And", self, other)

    def __invert__(self) -> Value:
        return self.graph.make("Not", self)


class Graph:
    """Inputs, operators, constants and outputs; what `model` makes a file of."""

    def __init__(self) -> None:
        self.inputs: dict[str, onnx.ValueInfoProto] = {}
        self.outputs: list[onnx.ValueInfoProto] = []
        self.memories: dict[str, tuple[int, type]] = {}
        self._nodes: list[onnx.NodeProto] = []
        self._constants: dict[tuple[str, tuple[int, ...], bytes], onnx.TensorProto] = {}

    def input(self, name: str, width: int = 1, dtype: type = np.float64) -> Value:
        """An input of shape (batch, width)."""
        self.inputs.setdefault(name, helper.make_tensor_value_info(name, _TYPES[dtype], ["batch", width]))
        return Value(self, name)

    def memory(self, name: str, width: int, dtype: type = np.float64) -> Value:
        """An input that is zero when an episode begins, and later what `remember` was given; (batch, width)."""
        self.memories[name] = (width, dtype)
        return self.input(name, width, dtype)

    def remember(self, name: str, value: Value) -> None:
        """Give a memory out as it is to come in at the next control step."""
        width, dtype = self.memories[name]
        self.output(NEXT + name, value, width, dtype)

    def output(self, name: str, value: Value, width: int = 1, dtype: type = np.float64) -> None:
        """An output of shape (batch, width)."""
        self._nodes.append(helper.make_node("Identity", [value.name], [name]))
        self.outputs.append(helper.make_tensor_value_info(name, _TYPES[dtype], ["batch", width]))

    def constant(self, value: Any, dtype: type = np.float64) -> Value:
        """A constant array; equal ones are kept once."""
        array: npt.NDArray[Any] = np.asarray(value, dtype=dtype)
        key = (array.dtype.str, array.shape, array.tobytes())
        if key not in self._constants:
            self._constants[key] = numpy_helper.from_array(array, f"constant_{len(self._constants)}")
        return Value(self, self._constants[key].name)

    def make(self, operator: str, *operands: Operand, **attributes: Any) -> Value:
        """The one output of an ONNX operator; numbers and arrays among its operands become constants of doubles."""
        names = [(one if isinstance(one, Value) else self.constant(one)).name for one in operands]
        name = f"{operator.lower()}_{len(self._nodes)}"
        self._nodes.append(helper.make_node(operator, names, [name], **attributes))
        return Value(self, name)

    def maximum(self, one: Operand, other: Operand) -> Value:
        """The larger of two."""
        return self.make("Max", one, other)

    def minimum(self, one: Operand, other: Operand) -> Value:
        """The smaller of two."""
        return self.make("Min", one, other)

    def clip(self, value: Operand, low: Operand, high: Operand) -> Value:
        """`value` within `low` and `high`, as `np.clip` has it."""
        return self.minimum(self.maximum(value, low), high)

    def where(self, condition: Value, one: Operand, other: Operand) -> Value:
        """`one` where the condition holds, `other` elsewhere."""
        return self.make("Where", condition, one, other)

    def cast(self, value: Value, dtype: type) -> Value:
        """The same as another kind of number."""
        return self.make("Cast", value, to=_TYPES[dtype])

    def columns(self, value: Value, first: int, end: int) -> Value:
        """Columns `first` to `end` - 1."""
        bounds = [self.constant([n], np.int64) for n in (first, end, 1)]
        return self.make("Slice", value, *bounds)

    def beside(self, *values: Value) -> Value:
        """Values side by side, as columns."""
        return self.make("Concat", *values, axis=1)

    def entry(self, table: npt.NDArray[Any], index: Value) -> Value:
        """Entry `index` (batch, 1), whole numbers, of a table (n, ...); shape (batch, ...)."""
        return self.make("Gather", table, self.make("Squeeze", index, self.constant([1], np.int64)), axis=0)

    def applied(self, matrix: Value, vector: Value) -> Value:
        """The products of matrices (batch, m, n), or one (m, n), and vectors (batch, n); shape (batch, m)."""
        axis = self.constant([2], np.int64)
        return self.make("Squeeze", self.make("MatMul", matrix, self.make("Unsqueeze", vector, axis)), axis)

    def total(self, value: Value) -> Value:
        """The sum of the columns, (batch, 1)."""
        return self.make("ReduceSum", value, self.constant([1], np.int64), keepdims=1)

    def spline(self, spline: CubicSpline, x: Value) -> Value:
        """A spline at x (batch, 1); outside its ends as its last pieces go on."""
        passed = self.cast(x >= spline.x[None, 1:-1], np.int64)
        piece = self.make("ReduceSum", passed, self.constant([1], np.int64), keepdims=1)
        table = np.column_stack([spline.x[:-1], spline.c.T])
        found = self.entry(table, piece)
        start, *powers = (self.columns(found, i, i + 1) for i in range(5))
        distance, value = x - start, powers[0]
        for power in powers[1:]:
            value = value * distance + power
        return value

    def model(self, name: str) -> onnx.ModelProto:
        """The graph as a model, checked."""
        constants = list(self._constants.values())
        made = helper.make_graph(self._nodes, name, list(self.inputs.values()), self.outputs, constants)
        opsets = [helper.make_opsetid("", OPSET)]
        model = helper.make_model(made, opset_imports=opsets, ir_version=IR_VERSION, producer_name="drillrig")
        onnx.checker.check_model(model)
        return model
