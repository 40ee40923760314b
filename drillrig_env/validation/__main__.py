"""Print what the chapter says beside what the model gives, as a Markdown page.

python -m drillrig_env.validation                               # to the terminal
python -m drillrig_env.validation --output docs/validation.md   # the page of the documentation

The page lists every number and statement of the source chapter that the model can be held to, with
equation or figure, the printed and the computed value, and a verdict; then what cannot be checked,
and why. Run it again after any change of the model, the rig's parameters or the stability analysis.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from drillrig_env.command_line import Parser, command
from drillrig_env.files import check_writable_file, write_text
from drillrig_env.validation.page import page


@command
def main(arguments: Sequence[str] | None = None) -> int:
    """Parse the command line, then print or write the page."""
    parser = Parser(prog="python -m drillrig_env.validation", description=__doc__)
    parser.add_argument("--output", type=Path, metavar="FILE.md", help="write the page there (default: print it)")
    output: Path | None = parser.parse_args(arguments).output
    if output is None:
        print(page(), end="")
        return 0
    check_writable_file(output)
    write_text(output, page())
    print(output.resolve())
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
