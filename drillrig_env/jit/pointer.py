"""Machine code and records by their addresses, for kernels that are compiled and kept before there is either.

The code is a C function as `numba.cfunc` makes it: of four doubles, which writes three doubles to where its fifth
argument points (`call`), or of a record and a double, which writes into the record (`call_on`). To the kernel its
address is a number like any other, so that its own code stays the same for every such function, and is kept on disk.
So it is with a function of Python's that `ctypes` makes callable (`answer_of`), which takes the lock of the interpreter
by itself.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

_built_in: Any = intrinsic  # their types say nothing of what they make
_alloca_once: Any = cgutils.alloca_once
_pointer_to: Any = types.CPointer
_tuple_of: Any = types.UniTuple

SIGNATURE = types.void(*[types.float64] * 4, _pointer_to(types.float64))
"""Numba's signature of a function for `call`."""


@_built_in
def call(_context: Any, address: Any, _a: Any, _b: Any, _c: Any, _d: Any) -> Any:
    """The three numbers that the function at `address` (int64) makes of four."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        double = ir.DoubleType()
        kind = ir.FunctionType(ir.VoidType(), [*[double] * 4, double.as_pointer()])
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        out = _alloca_once(builder, double, size=3)
        builder.call(function, [*arguments[1:], out])
        values = [builder.load(builder.gep(out, [ir.Constant(ir.IntType(32), i)])) for i in range(3)]
        return context.make_tuple(builder, signature.return_type, values)

    numbers = _tuple_of(types.float64, 3)
    return numbers(types.int64, *[types.float64] * 4), generate


@_built_in
def call_on(_context: Any, address: Any, record: Any, _number: Any) -> Any:
    """Let the function at `address` (int64) write into a `record`, given a number."""

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        place = ir.IntType(8).as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [place, ir.DoubleType()])
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        builder.call(function, [builder.bitcast(arguments[1], place), arguments[2]])
        return context.get_dummy_value()

    return types.void(types.int64, record, types.float64), generate


@_built_in
def answer_of(_context: Any, address: Any, _number: Any) -> Any:
    """What the function at `address` (int64), of one int64, returns: an int64."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        whole = ir.IntType(64)
        function = builder.inttoptr(arguments[0], ir.FunctionType(whole, [whole]).as_pointer())
        return builder.call(function, [arguments[1]])

    return types.int64(types.int64, types.int64), generate


@_built_in
def record_at(_context: Any, address: Any, like: Any) -> Any:
    """The record at `address` (int64), of the type of `like`. Nothing is checked."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

    return like(types.int64, like), generate
