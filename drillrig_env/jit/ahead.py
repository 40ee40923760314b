"""Memory that a kernel is about to need, asked for ahead of time.

A processor fetches by itself what lies one after the other. Where a kernel goes through an array in another order,
every line that it meets would keep it waiting for some hundred instructions.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

_built_in: Any = intrinsic  # its type says nothing of what it makes
_declared: Any = cgutils.get_or_insert_function

_LINE = 64
"""Bytes that a processor fetches at once."""

_TO_READ, _SOON, _DATA = 0, 3, 1
"""What LLVM calls the intention, the nearness to the processor and the kind of what is fetched."""


@_built_in
def fetch(_context: Any, array: Any, _index: Any) -> Any:
    """Ask for the record at an index of an array, or for where a row begins; nothing is checked, or changed."""
    size = getattr(array.dtype, "size", 1)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        whole, place = ir.IntType(32), ir.IntType(8).as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [place, whole, whole, whole])
        prefetch = _declared(builder.module, kind, "llvm.prefetch.p0i8")
        view = context.make_array(signature.args[0])(context, builder, arguments[0])
        stride = builder.extract_value(view.strides, 0)
        begin = builder.add(builder.ptrtoint(view.data, stride.type), builder.mul(arguments[1], stride))
        for line in range(0, size + _LINE - 1, _LINE):  # it may begin in the midst of one
            there = builder.inttoptr(builder.add(begin, ir.Constant(stride.type, line)), place)
            builder.call(prefetch, [there, *(ir.Constant(whole, code) for code in (_TO_READ, _SOON, _DATA))])
        return context.get_dummy_value()

    return types.void(array, types.intp), generate
