"""Tests open no window: SDL gets a driver without a screen before anything imports it."""

import os

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
