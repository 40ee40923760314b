"""A long compilation is announced once; a short one, and what comes from a cache, is not."""

import time
from types import SimpleNamespace

import pytest

from drillrig_env.jit import announcement
from drillrig_env.jit.announcement import Announcement


def compilation(module):
    def function():
        pass

    function.__module__ = module
    return SimpleNamespace(data={"dispatcher": SimpleNamespace(py_func=function)})


def compile_for(listener, seconds, *modules):
    events = [compilation(module) for module in modules]
    for event in events:
        listener.on_start(event)
    time.sleep(seconds)
    for event in reversed(events):
        listener.on_end(event)


@pytest.mark.slow
def test_only_a_long_compilation_of_the_package_is_announced_and_only_once(monkeypatch, capsys):
    monkeypatch.setattr(announcement, "_PATIENCE", 0.2)
    listener = Announcement("rigs")
    compile_for(listener, 0.0, "rigs.kernel", "numba.builtins")
    compile_for(listener, 0.5, "somebody.else")
    compile_for(listener, 0.0, None)  # a function that has no module
    assert capsys.readouterr().err == ""
    compile_for(listener, 1.0, "rigs.kernel", "numba.builtins")
    compile_for(listener, 0.5, "rigs.kernel")
    assert capsys.readouterr().err == "drillrig: compiling the kernels, once (about 5 s)\n"
