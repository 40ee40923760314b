"""Draw the chapter's figures 4.1 to 4.13 and the bistable region, each with its caption.

python -m drillrig_env.plots                              # all of them, as PNG and SVG, into figures/
python -m drillrig_env.plots --only 4.12 4.13 --format svg --output paper
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from drillrig_env.parameters import closest
from drillrig_env.plots.figures import FIGURES, FORMATS, write


def main(arguments: Sequence[str] | None = None) -> int:
    """Parse the command line, draw and report; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m drillrig_env.plots",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--output", type=Path, default=Path("figures"), metavar="FOLDER", help="folder for the files (default: figures)"
    )
    parser.add_argument(
        "--only", nargs="+", default=list(FIGURES), metavar="NAME", help=f"draw only these: {', '.join(FIGURES)}"
    )
    parser.add_argument("--format", nargs="+", choices=FORMATS, default=list(FORMATS), help="default: png and svg")
    options = parser.parse_args(arguments)
    for name in options.only:
        if name not in FIGURES:
            parser.error(f"--only: figure {name!r} is not known; {closest(name, FIGURES)}")
    names = list(dict.fromkeys(options.only))
    try:
        from rich.progress import Progress
    except ImportError:
        parser.error("the progress bar needs rich; install it with: pip install 'drillrig[agents]'")

    written: list[str] = []
    try:
        with Progress() as progress:
            task = progress.add_task("figures", total=len(names))
            for name in write(options.output, names, options.format):
                written.append(name)
                progress.update(task, advance=1, description=f"figure {name}")
    except KeyboardInterrupt:
        print(f"stopped; written so far: {', '.join(written) or 'nothing'}, in {options.output.resolve()}")
        return 130
    except OSError as error:
        parser.error(str(error))
    print(f"{', '.join(written)} and captions.md: {options.output.resolve()}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
