"""Work and results on their way between processes and machines: as bytes, with what the receiver does not have.

What a Python file of the user's own defines travels by value: nobody else has that file. The project and all
packages travel by name, and are to be the same on both sides (see `drillrig_env.engine.likeness`).
"""

from __future__ import annotations

import sys
from typing import Any

import cloudpickle

from drillrig_env.command_line import Failed
from drillrig_env.modules import of_the_user


def packed(content: Any) -> bytes:
    """Anything as bytes. `Failed`, saying what, where it cannot travel."""
    registered = []
    for name in of_the_user():
        module = sys.modules.get(name)
        if module is not None and name not in cloudpickle.list_registry_pickle_by_value():
            cloudpickle.register_pickle_by_value(module)
            registered.append(module)
    try:
        return bytes(cloudpickle.dumps(content))
    except Exception as error:  # whatever an object's own pickling raises
        raise Failed(f"this cannot be sent to another process: {type(error).__name__}: {error}") from error
    finally:
        for module in registered:
            cloudpickle.unregister_pickle_by_value(module)


def unpacked(content: bytes) -> Any:
    """What `packed` made bytes of."""
    return cloudpickle.loads(content)


def packed_error(error: BaseException) -> bytes:
    """An error as bytes, or where it cannot travel another with the same words."""
    try:
        content = packed(error)
        unpacked(content)  # many an error is packed and cannot be made again
    except Exception:
        content = packed(Failed(f"{type(error).__name__}: {error}"))
    return content
