"""One check: a number or statement of the chapter beside what the model gives, and the verdict."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """A row of the page. `agrees` is computed, never written down; `remark` says why, or what more there is.

    `where` is its place in the chapter, and `statement` what is said there, `printed` and as `computed`.

    `difference` and `tolerance` are those of a printed number, in its own unit; None for a statement.
    """

    where: str
    statement: str
    printed: str
    computed: str
    agrees: bool
    remark: str = ""
    difference: float | None = None
    tolerance: float | None = None

    @property
    def verdict(self) -> str:
        """The word "agrees" or "differs", with the remark."""
        word = "agrees" if self.agrees else "**differs**"
        return f"{word}: {self.remark}" if self.remark else word


def number(
    where: str,
    statement: str,
    printed: float,
    computed: float,
    unit: str,
    *,
    tolerance: float,
    decimals: int,
    remark: str = "",
) -> Check:
    """A check of a printed number: it agrees when the computed one is within `tolerance` (in `unit`).

    `decimals` are those of the computed number on the page: two more than printed, to show how near it is.
    """
    return Check(
        where,
        statement,
        f"{printed:g} {unit}",
        f"{computed:.{decimals}f} {unit}",
        abs(computed - printed) <= tolerance,
        remark,
        round(computed - printed, decimals),
        tolerance,
    )


def claim(where: str, statement: str, computed: str, agrees: bool, remark: str = "", printed: str = "") -> Check:
    """A check of a statement in words, or of a formula (`printed`), that the model bears out or does not."""
    return Check(where, statement, printed, computed, agrees, remark)
