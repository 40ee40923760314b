"""Rows of a table as vectors of the processor, for kernels: several products and sums in one instruction.

LLVM turns Numba's short loops into one scalar instruction after the other. Here a kernel says that the entries
of a row go together:

    store(out, 0, y[0] * row(A, 0, 8) + y[1] * row(A, 1, 8))

is out[i] = y[0] * A[0, i] + y[1] * A[1, i] for i = 0 to 7, bit for bit. Nothing is checked: rows must lie in one
piece and be long enough.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import TypingError, types
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.extending import intrinsic, lower_builtin, models, register_model

_built_in: Any = intrinsic  # their types say nothing of what they make
_put_beside: Any = infer_global
_lower: Any = lower_builtin


class Lanes(types.Type):
    """Numba's type of a vector of `count` doubles."""

    def __init__(self, count: int) -> None:
        self.count = count
        super().__init__(name=f"lanes({count})")

    @property
    def vector(self) -> Any:
        """LLVM's type of it."""
        return ir.VectorType(ir.DoubleType(), self.count)


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, lanes: Lanes) -> None:
        super().__init__(manager, lanes, lanes.vector)  # type: ignore[no-untyped-call]


def _address(context: Any, builder: Any, array_type: Any, array: Any, index: Any, lanes: Lanes) -> Any:
    """Where a row, or in an array of one axis an entry, begins."""
    view = context.make_array(array_type)(context, builder, array)
    stride = builder.extract_value(view.strides, 0)
    place = builder.add(builder.ptrtoint(view.data, stride.type), builder.mul(index, stride))
    return builder.inttoptr(place, lanes.vector.as_pointer())


@_built_in(prefer_literal=True)
def row(_context: Any, table: Any, index: Any, count: Any) -> Any:
    """The first `count` entries of row `index` of a table, or those from entry `index` of an array of one axis.

    `count` is a constant.
    """
    if not isinstance(count, types.IntegerLiteral):
        raise TypingError("the count of a row must be a constant")
    lanes = Lanes(count.literal_value)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number = context.cast(builder, arguments[1], signature.args[1], types.intp)
        address = _address(context, builder, signature.args[0], arguments[0], number, lanes)
        return builder.load(address, align=8)

    return lanes(table, index, count), generate


@_built_in
def store(_context: Any, array: Any, first: Any, lanes: Any) -> Any:
    """Put a vector into an array of one axis, at the entries `first` and on."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number = context.cast(builder, arguments[1], signature.args[1], types.intp)
        address = _address(context, builder, signature.args[0], arguments[0], number, lanes)
        builder.store(arguments[2], address, align=8)
        return context.get_dummy_value()

    return types.void(array, first, lanes), generate


def _offer(symbol: Callable[..., Any], operation: str) -> None:
    """Let an operator work on two vectors, and on a number and a vector, by one instruction of LLVM.

    It is put beside Numba's own operators: an `overload` would be compiled at every place where it stands.
    """

    class OnLanes(AbstractTemplate):
        def generic(self, arguments: Any, _keywords: Any) -> Any:
            left, right = arguments
            if isinstance(right, Lanes) and (left == right or isinstance(left, types.Float)):
                return right(types.float64 if isinstance(left, types.Float) else left, right)
            return None

    def two_vectors(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return getattr(builder, operation)(*arguments)

    def number_and_vector(_context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        lanes = signature.return_type
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), lanes.count), None)
        only = ir.Constant(ir.IntType(32), 0)
        one = builder.insert_element(ir.Constant(lanes.vector, ir.Undefined), arguments[0], only)
        return getattr(builder, operation)(builder.shuffle_vector(one, one, zeros), arguments[1])

    _put_beside(symbol)(OnLanes)
    _lower(symbol, Lanes, Lanes)(two_vectors)
    _lower(symbol, types.Float, Lanes)(number_and_vector)


_offer(operator.add, "fadd")
_offer(operator.mul, "fmul")
