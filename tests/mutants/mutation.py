"""Mutants of a source file: each a small change of its meaning that some test ought to notice.

The source is read with `ast`, and each change is an edit of its very bytes, so that all else keeps its lines:
comparisons, arithmetic, `and` and `or`, `not` and minus signs, numbers and defaults, the larger for the smaller,
returned values and refusals. What only people read is left alone: docstrings, error texts, annotations,
imports for the type checker, tables of tuned values. So are assertions, `strict=True` of a zip among them: they say
what always holds, and change nothing while it does.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass

_COMPARISONS = {
    ast.Lt: ("<", ("<=", ">=")),
    ast.LtE: ("<=", ("<", ">")),
    ast.Gt: (">", (">=", "<=")),
    ast.GtE: (">=", (">", "<")),
    ast.Eq: ("==", ("!=",)),
    ast.NotEq: ("!=", ("==",)),
    ast.Is: ("is", ("is not",)),
    ast.IsNot: ("is not", ("is",)),
    ast.In: ("in", ("not in",)),
    ast.NotIn: ("not in", ("in",)),
}
_ARITHMETIC = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.FloorDiv: ("//", "*"),
    ast.Mod: ("%", "*"),
    ast.Pow: ("**", "*"),
    ast.LShift: ("<<", ">>"),
    ast.RShift: (">>", "<<"),
    ast.BitAnd: ("&", "|"),
    ast.BitOr: ("|", "&"),
    ast.BitXor: ("^", "&"),
}
_OPPOSITES = {
    "min": "max",
    "minimum": "maximum",
    "fmin": "fmax",
    "argmin": "argmax",
    "any": "all",
    "floor": "ceil",
    "sin": "cos",
}
_OPPOSITES |= {there: back for back, there in _OPPOSITES.items()}
_UNREAD_CALLS = {"refuse", "closest", "warn", "print", "dtype", "TypeVar", "cast"}
"""Calls whose arguments are words for people, or layouts."""

_UNREAD_NAMES = {"tuned", "tuned_values", "__all__"}
_TINY = 1e-3
"""Numbers below this are tolerances: twice as much would hardly matter to anybody, so they grow a thousandfold."""


@dataclass(frozen=True)
class Mutant:
    """A change of one place: the bytes from `start` to `end` of a `file` become `replacement`.

    `before` and `after` are the source line with and without it; they say what a mutant is where the
    number of its `line` has moved.
    """

    file: str
    line: int
    start: int
    end: int
    replacement: str
    before: str
    after: str

    def applied_to(self, source: bytes) -> bytes:
        """The source of the mutated file."""
        return source[: self.start] + self.replacement.encode() + source[self.end :]


def mutants_of(source: bytes, file: str) -> list[Mutant]:
    """Every mutant of a Python source, in the order of its text. `SyntaxError` where it is not Python."""
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []
    for number, (start, end, replacement) in enumerate(_Source(source, starts).edits(ast.parse(source))):
        line = next(i for i in range(len(starts) - 1) if starts[i + 1] > start)
        last = next(i for i in range(line, len(starts) - 1) if starts[i + 1] >= end)
        head, tail = source[starts[line] : start], source[end : starts[last + 1]]
        before = source[starts[line] : starts[last + 1]].decode().strip()
        after = (head + replacement.encode() + tail).decode().strip()
        found.append((start, number, Mutant(file, line + 1, start, end, replacement, before, after)))
    return [mutant for _, _, mutant in sorted(found, key=lambda one: one[:2])]


Edit = tuple[int, int, str]


class _Source:
    """A source text, with places as `ast` gives them (line and byte within it) turned into bytes of the whole."""

    def __init__(self, source: bytes, starts: list[int]) -> None:
        self.source = source
        self.starts = starts

    def _span(self, node: ast.expr | ast.stmt) -> tuple[int, int]:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return self.starts[node.lineno - 1] + node.col_offset, self.starts[node.end_lineno - 1] + node.end_col_offset

    def _between(self, left: ast.expr, right: ast.expr, token: str, replacements: tuple[str, ...]) -> Iterator[Edit]:
        """Edits of the operator between two operands; comments between them do not count."""
        low, high = self._span(left)[1], self._span(right)[0]
        between = re.sub(rb"#[^\n]*", lambda comment: b" " * len(comment[0]), self.source[low:high])
        word = r"\b" if token[0].isalpha() else ""
        pattern = word + r"\s+".join(re.escape(part) for part in token.split()) + word
        place = re.search(pattern.encode(), between)
        assert place is not None, (token, between)
        for replacement in replacements:
            yield low + place.start(), low + place.end(), replacement

    def edits(self, node: ast.AST) -> Iterator[Edit]:
        """All edits of a node and of what it holds."""
        yield from self._own(node)
        for child in self._children(node):
            yield from self.edits(child)

    def _children(self, node: ast.AST) -> list[ast.AST]:
        """What a node holds, less what only people and type checkers read."""
        if _is_unread(node):
            return []
        unread: list[object] = [getattr(node, "annotation", None), getattr(node, "returns", None)]
        unread += getattr(node, "decorator_list", [])
        if isinstance(node, ast.Call):
            unread += [word for word in node.keywords if _is_unread_argument(_name_of(node.func), word)]
        return [child for child in ast.iter_child_nodes(node) if child not in unread]

    def _own(self, node: ast.AST) -> Iterator[Edit]:
        """Edits of a node itself."""
        if isinstance(node, ast.Compare):
            operands = [node.left, *node.comparators]
            for operator, left, right in zip(node.ops, operands, operands[1:], strict=False):
                yield from self._between(left, right, *_COMPARISONS[type(operator)])
        elif isinstance(node, ast.BinOp) and type(node.op) in _ARITHMETIC:
            token, other = _ARITHMETIC[type(node.op)]
            yield from self._between(node.left, node.right, token, (other,))
        elif isinstance(node, ast.AugAssign) and type(node.op) in _ARITHMETIC:
            token, other = _ARITHMETIC[type(node.op)]
            yield from self._between(node.target, node.value, f"{token}=", (f"{other}=",))
        elif isinstance(node, ast.BoolOp):
            token, other = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
            for left, right in zip(node.values, node.values[1:], strict=False):
                yield from self._between(left, right, token, (other,))
        elif isinstance(node, ast.UnaryOp) and not isinstance(node.op, ast.UAdd):
            token = "not" if isinstance(node.op, ast.Not) else "~"
            yield self._span(node)[0], self._span(node)[0] + len(token), ""
        elif isinstance(node, ast.Constant):
            yield from ((*self._span(node), other) for other in _other_constants(node.value))
        elif isinstance(node, ast.Call) and (name := _name_of(node.func)) in _OPPOSITES:
            end = self._span(node.func)[1]
            yield end - len(name), end, _OPPOSITES[name]
        elif isinstance(node, ast.Return) and node.value is not None and not _is_none(node.value):
            yield (*self._span(node.value), "None")
        elif isinstance(node, ast.Raise) or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)):
            yield (*self._span(node), "pass")


def _is_unread(node: ast.AST) -> bool:
    """Whether what a node holds is for people, for type checkers or for the command line."""
    if isinstance(node, ast.If):
        return ast.unparse(node.test) in ("TYPE_CHECKING", "__name__ == '__main__'")
    if isinstance(node, ast.Call):
        return _name_of(node.func) in _UNREAD_CALLS
    if isinstance(node, ast.Assign | ast.AnnAssign):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        return any(_name_of(target) in _UNREAD_NAMES for target in targets)
    return isinstance(node, ast.JoinedStr | ast.Raise | ast.Assert | ast.Import | ast.ImportFrom)


def _other_constants(value: object) -> tuple[str, ...]:
    if isinstance(value, bool):
        return (str(not value),)
    if isinstance(value, int):
        return (str(value + 1),)
    if isinstance(value, float):
        other = 1.0 if value == 0.0 else 2.0 * value if abs(value) >= _TINY else 1e3 * value
        return (repr(float(f"{other:.12g}")),)
    return ()


def _name_of(node: ast.expr) -> str:
    return node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _is_unread_argument(function: str, argument: ast.keyword) -> bool:
    """Whether an argument of a call is an assertion, or decides of what people read."""
    if function == "zip" and argument.arg == "strict":
        return isinstance(argument.value, ast.Constant) and argument.value.value is True
    return function == "field" and argument.arg == "repr"
