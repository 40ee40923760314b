"""What pyproject.toml cannot say: a wheel holds the parts of the control room's page, which npm fetches for it."""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

PARTS = Path(__file__).parent / "drillrig_env" / "room" / "parts.py"


class BuildWithParts(build_py):
    """Copy the modules, once the page has its parts; without npm the wheel has none, and its room says so."""

    def run(self):
        """Fetch the parts where they are missing, then build."""
        spec = spec_from_file_location("parts", PARTS)
        parts = module_from_spec(spec)
        spec.loader.exec_module(parts)
        if not self.editable_mode and not (parts.PARTS / "uPlot.js").is_file():
            try:
                parts.fetch()
            except parts.PartsError as error:
                print(f"warning: `drillrig room` will lack its page: {error}", file=sys.stderr)
        super().run()


setup(cmdclass={"build_py": BuildWithParts})
