"""The command `drillrig`: a first word says what is done, and the rest is that command's own.

A command is a `main(arguments, prog)` that returns an exit code (see `drillrig_env.command_line`); its module
is imported when it is called, so that `drillrig --help` answers at once.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Mapping, Sequence

from drillrig_env.command_line import Parser
from drillrig_env.parameters import closest
from drillrig_env.starting import imports_begin, imports_end

COMMANDS: Mapping[str, tuple[str, str]] = {
    "info": ("drillrig_env.cli.info", "a rig in numbers: parameters, critical speed, fold, periods; write a rig file"),
    "simulate": ("drillrig_env.cli.simulate", "run a rig in time: a summary, a CSV file, a picture"),
    "figures": ("drillrig_env.plots.__main__", "draw the chapter's figures and the bistable region for a rig"),
    "calibrate": ("drillrig_env.calibrate.command", "fit a rig and its friction to records of it"),
    "measured": ("drillrig_env.calibrate.measured", "score a measured run against the model"),
    "evaluate": ("drillrig_env.cli.evaluate", "compare policies on the same random rigs"),
    "train": ("drillrig_env.cli.train", "train an agent (in a clone of the project)"),
    "room": ("drillrig_env.room.command", "the control room: two rigs live in the browser, hands on force and speed"),
    "export": ("drillrig_env.deploy.export", "write a law or a trained agent as one ONNX file, for hardware"),
    "twin": ("drillrig_env.twin.command", "run a simulated rig in a process of its own, to connect to"),
    "run": ("drillrig_env.deploy.run", "let a policy's file control a rig that is connected: real, or a twin"),
    "replay": ("drillrig_env.deploy.replay", "play the log of a controller through it again, to the last bit"),
    "animate": ("drillrig_env.plots.animation", "film a rig that sticks and slips until a policy frees it"),
}
"""Every command: the module that has its `main`, and what it does."""

_LINES = "\n".join(f"  {name:<10}{about}" for name, (_, about) in COMMANDS.items())

_DESCRIPTION = f"""Stick-slip of a drill string: simulate it, analyse it, and let controllers and agents meet it.

commands:
{_LINES}
"""

_EPILOG = """\
a first look:
  drillrig info --normal-force 20                 # below which speed does the rig stick and slip?
  drillrig simulate --speed-reference 2.5 --normal-force 20 --picture run.png
  drillrig evaluate constant lqg --suite default --rigs 200

a rig of your own:
  drillrig info --write my_rig.toml               # the chapter's rig, a line a parameter: edit it
  drillrig info --rig my_rig.toml
  drillrig figures --rig my_rig.toml

`drillrig COMMAND --help` explains a command. Exit codes: 0 done, 1 something failed, 2 the arguments are
not allowed, 130 stopped by Ctrl-C, 143 by SIGTERM.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Find the command that the first word names, and let it do the rest; its exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    parser = Parser(prog="drillrig", description=_DESCRIPTION, epilog=_EPILOG, usage="drillrig COMMAND ...")
    parser.add_argument("--version", action="store_true", help="print the version and end")
    parser.add_argument("command", nargs="?", help=argparse.SUPPRESS)
    chosen = parser.parse_args(words[:1])
    if chosen.version:
        import drillrig_env

        print(f"drillrig {drillrig_env.__version__}")
        return 0
    if chosen.command is None:
        parser.print_help()
        return 0
    if chosen.command not in COMMANDS:
        parser.error(f"command {chosen.command!r} is not known; {closest(chosen.command, COMMANDS)}")
    return start(chosen.command, words[1:], f"drillrig {chosen.command}")


def start(command: str, arguments: Sequence[str] | None, prog: str) -> int:
    """Import a command and let it do the rest; its exit code. `prog` is what it calls itself."""
    imports_begin()
    module = importlib.import_module(COMMANDS[command][0])
    imports_end()
    code: int = module.main(arguments, prog=prog)
    return code
