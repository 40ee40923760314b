"""The page of the command lines: what each prints for `--help`."""

from __future__ import annotations

import inspect
import io
import os
from contextlib import redirect_stdout
from importlib import import_module
from unittest.mock import patch

from drillrig_env import command_line
from drillrig_env.cli import COMMANDS
from drillrig_env.markdown import sentence

IN_CLONE = {
    "python train.py": "train",
    "python eval.py": "drillrig_env.cli.evaluate",
    "python -m agents.export": "agents.export",
    "python -m agents.dataset": "agents.dataset.__main__",
    "python -m baselines.tune": "baselines.tune",
    "python -m drillrig_env.twin.dry_run": "drillrig_env.twin.dry_run",
    "python -m docs.make": "docs.make.__main__",
}
"""Commands beside `drillrig`, and the module that has the `main` of each."""

WIDTH = 100


_ABOUT = """\
# Command lines

What every command prints for `--help`. `drillrig` comes with `pip install`; those that begin with `python` run in a
clone of the project."""


def page() -> str:
    """All commands, each with its help."""
    parts = [_ABOUT, _exit_codes(), "## `drillrig`", _block(help_of("drillrig_env.cli", "drillrig"))]
    for name, (module, about) in COMMANDS.items():
        if name != "train":  # hands over to train.py
            parts += [f"## `drillrig {name}`", sentence(about), _block(help_of(module, f"drillrig {name}"))]
    parts += ["## `drillrig train`", "The same as `python train.py`, in a clone."]
    for name, module in IN_CLONE.items():
        if name == "python eval.py":
            parts += [f"## `{name}`", "The same as `drillrig evaluate`."]
        else:
            parts += [f"## `{name}`", _block(help_of(module, name))]
    return "\n\n".join(parts) + "\n"


def help_of(module: str, name: str) -> str:
    """What a command prints for `--help`. `RuntimeError` where it does not end as it should."""
    main, out = import_module(module).main, io.StringIO()
    given = {"prog": name} if "prog" in inspect.signature(main).parameters and name != "drillrig" else {}
    with patch.dict(os.environ, {"COLUMNS": str(WIDTH)}), redirect_stdout(out):
        try:
            main(["--help"], **given)
        except SystemExit as end:
            if end.code:
                raise RuntimeError(f"{name} --help ended with {end.code}") from end
    return out.getvalue()


def _exit_codes() -> str:
    """The table of exit codes that all commands have in common."""
    return "Every command ends with one of these exit codes:\n\n" + (command_line.__doc__ or "").partition("\n\n")[2]


def _block(text: str) -> str:
    return f"```text\n{text.rstrip()}\n```"
