"""What to install for what the package can do beyond its core."""


def missing(purpose: str, packages: str, extra: str) -> ImportError:
    """The error for a package that is not installed: who needs it, and how to get it, with the extra of that name.

    >>> str(missing("rendering", "pygame-ce", "render"))
    "rendering needs pygame-ce; in a clone of DrillRig: pip install -e '.[render]'"
    """
    return ImportError(f"{purpose} needs {packages}; in a clone of DrillRig: pip install -e '.[{extra}]'")


_EXTRA_OF = {
    "stable_baselines3": "agents",
    "sb3_contrib": "agents",
    "torch": "agents",
    "yaml": "agents",
    "asyncua": "opcua",
    "onnx": "export",
    "onnxruntime": "deploy",
    "matplotlib": "plot",
    "pygame": "render",
    "PIL": "render",
    "emcee": "posterior",
    "optuna": "scale",
    "ray": "scale",
    "nptdms": "records",
    "openpyxl": "records",
    "msgspec": "room",
    "starlette": "room",
    "uvicorn": "room",
    "websockets": "room",
    "pandas": "records",
    "pyarrow": "records",
}
"""Which extra brings a package that the project imports, by the name that is imported."""


def advice(error: ImportError) -> str | None:
    """What to tell of an import that failed for want of an extra; None where that is not why it failed.

    >>> advice(ModuleNotFoundError("No module named 'torch.nn'", name="torch.nn"))
    "this needs torch; in a clone of DrillRig: pip install -e '.[agents]'"
    """
    if error.name is None:
        return str(error)  # a sentence of `missing`
    package = error.name.partition(".")[0]
    found = isinstance(error, ModuleNotFoundError) and package in _EXTRA_OF
    return str(missing("this", package, _EXTRA_OF[package])) if found else None
