"""The shipped agents that a command is for: those that its line names, or all of them."""

from __future__ import annotations

import argparse

from agents.policy.run_folder import shipped
from drillrig_env.parameters import closest


def add_names_argument(parser: argparse.ArgumentParser) -> None:
    """Add `NAME ...`: the option `names` is a list of shipped agents, all of them where none is named.

    A name that is no shipped agent's is a bad argument, whose sentence has the closest one.
    """
    every = shipped()
    about = f"shipped agents (default: {', '.join(every) or 'none yet'})"
    parser.add_argument("names", nargs="*", type=_shipped, default=every, metavar="NAME", help=about)


def _shipped(name: str) -> str:
    if name not in shipped():
        raise argparse.ArgumentTypeError(f"{name!r} is no shipped agent; {closest(name, shipped())}")
    return name
