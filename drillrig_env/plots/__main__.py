"""Draw the chapter's figures 4.1 to 4.13, the bistable region and other laws of friction, each with its caption.

  drillrig figures                              # all of them, as PNG and SVG, into figures/
  drillrig figures --only 4.12 4.13 --format svg --output paper
  drillrig figures --rig my_rig.toml            # for a rig of your own

On a rig of your own, axes of speeds reach as far beside its fold as they do beside the chapter's; times, normal forces
and friction are those that correspond to the chapter's. A figure of what the rig does not have, such as stick-slip, is
left out with a sentence.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from drillrig_env.command_line import DONE, FAILED, Parser, command
from drillrig_env.files import check_writable
from drillrig_env.flags import add_rig_argument
from drillrig_env.parameters import closest


@command
def main(arguments: Sequence[str] | None = None, prog: str = "python -m drillrig_env.plots") -> int:
    """Parse the command line, draw and report; returns the exit code."""
    parser = Parser(prog=prog, description=__doc__)
    add = parser.add_argument
    add_rig_argument(parser)
    add("--output", type=Path, default=Path("figures"), metavar="FOLDER", help="for the files (default: figures)")
    add("--only", nargs="+", metavar="NAME", help="draw only these, such as 4.12 or bistable")
    add("--format", nargs="+", choices=("png", "svg"), default=["png", "svg"], help="default: png and svg")
    options = parser.parse_args(arguments)
    try:
        from drillrig_env.plots.figures import FIGURES, write
    except ImportError as error:
        parser.error(error)
    for name in options.only or ():
        if name not in FIGURES:
            parser.error(f"--only: figure {name!r} is not known; {closest(name, FIGURES)}")
    check_writable(options.output)
    names = list(dict.fromkeys(options.only or FIGURES))
    written: list[str] = []
    with Progress(console=Console(stderr=True)) as progress:
        task = progress.add_task("figures", total=len(names))
        try:
            for name in names:
                try:
                    written += write(options.output, [name], options.format, options.rig)
                except ValueError as error:
                    print(f"{prog}: figure {name} is left out: {error}", file=sys.stderr)
                progress.update(task, advance=1, description=f"figure {name}")
        except KeyboardInterrupt as stop:
            stop.add_note(f"written so far: {', '.join(written) or 'nothing'}, in {options.output.resolve()}")
            raise
    print(f"{', '.join(written)} and captions.md: {options.output.resolve()}")
    return DONE if len(written) == len(names) else FAILED


if __name__ == "__main__":
    raise SystemExit(main())
