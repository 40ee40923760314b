"""Tests open no window, hear Ctrl-C, and compare with Radau at a tolerance that is fine enough for what they ask.

SDL gets a driver without a screen before anything imports it. What a shell starts with `&` may be deaf to Ctrl-C, which
tests send to themselves.
"""

import os
import signal
from functools import partial

import pytest

from drillrig_env import simulation
from drillrig_env.reference import radau

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def coarser_radau(monkeypatch):
    """`method="radau"` in a third of the time, for agreement to 1e-7: a hundred times this tolerance."""
    coarser = simulation._by_pieces(partial(radau, rtol=1e-9, atol=1e-11))
    monkeypatch.setitem(simulation._METHODS, "radau", coarser)
