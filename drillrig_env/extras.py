"""What to install for what the package can do beyond its core."""


def missing(purpose: str, packages: str, extra: str) -> ImportError:
    """The error for a package that is not installed: who needs it, and how to get it, with the extra of that name.

    >>> str(missing("rendering", "pygame-ce", "render"))
    "rendering needs pygame-ce; in a clone of DrillRig: pip install '.[render]'"
    """
    return ImportError(f"{purpose} needs {packages}; in a clone of DrillRig: pip install '.[{extra}]'")
