"""The site: `make docs` builds it from these pages, from the docstrings and from the examples. Nothing is fetched."""

from __future__ import annotations

import sys
import warnings
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

import drillrig_env  # noqa: E402

project, author = "DrillRig", "the authors of DrillRig"
version = release = drillrig_env.__version__

extensions = ["myst_parser", "sphinx_copybutton", "sphinx.ext.viewcode", "sphinx_gallery.gen_gallery", "docs.site"]
exclude_patterns = [
    "_build",
    "**/findings.md",
    "**/notes.md",
    "generated/gallery/**/*.ipynb",
    "generated/gallery/**/*.py",
]
nitpicky = True
nitpick_ignore_regex = [("py:.*", r"(?!drillrig_env|baselines).*")]  # NumPy's, Gymnasium's: no inventory is fetched
suppress_warnings = ["toc.empty_glob", "config.cache"]

myst_heading_anchors = 4
python_maximum_signature_line_length = 100
toc_object_entries_show_parents = "hide"

html_theme = "furo"
html_title = "DrillRig"
html_show_sourcelink = False
html_copy_source = False
copybutton_exclude = ".linenos, .gp, .go"
"""The button copies what one types: no prompts and no output."""

SMALL = {"ppo_in_two_minutes.py": ["150000"]}
"""Arguments with which examples are run for their page, where they take much longer without."""

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "generated/gallery",
    "filename_pattern": r"\.py$" if find_spec("minari") else r"(?<!offline_data)\.py$",
    "within_subsection_order": "ExampleTitleSortKey",
    "reset_argv": lambda _settings, script: SMALL.get(Path(script["src_file"]).name, []),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_signature": False,
    "show_memory": False,
    "min_reported_time": 1000,
    "write_computation_times": False,
    "plot_gallery": True,
}
warnings.filterwarnings("ignore", message=".*non-interactive", category=UserWarning)
