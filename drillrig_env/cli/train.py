"""Train an agent, as `train.py` in a clone of the project does."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

from drillrig_env.command_line import Failed, Parser, command
from drillrig_env.extras import advice

_HOW = (
    "agents are trained in a clone of the project, and there is none here: get its sources, and in their folder "
    "`pip install --editable '.[agents]'`; this command then works in every folder"
)


@command
def main(arguments: Sequence[str] | None = None, prog: str = "drillrig train") -> int:
    """Hand the command line to the clone's `train.py`; where there is no clone, say how to get one."""
    clone = _clone()
    if clone is None:
        parser = Parser(prog=prog, description=f"{__doc__}\nNot here, though: {_HOW}.")
        parser.parse_args([word for word in arguments or () if word in ("-h", "--help")])
        parser.error(_HOW)
    try:
        train = _train(clone)
    except ImportError as error:
        if (told := advice(error)) is None:
            raise
        raise Failed(told) from error
    code: int = train.main(arguments, prog=prog)
    return code


def _clone() -> Path | None:
    """The clone that this package runs from, or else that of the working folder."""
    for folder in (Path(__file__).parents[2], Path.cwd()):
        if (folder / "train.py").is_file() and (folder / "agents" / "training").is_dir():
            return folder
    return None


def _train(clone: Path) -> ModuleType:
    """The clone's `train.py` as a module, with the clone's `agents` ahead of any other package of that name."""
    sys.path.insert(0, str(clone))
    spec = importlib.util.spec_from_file_location("train", clone / "train.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["train"] = module
    spec.loader.exec_module(module)
    return module
