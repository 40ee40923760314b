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
toc_object_entries_show_parents = "hide"

html_theme = "furo"
html_title = "DrillRig"
html_static_path, html_css_files = ["site/static"], ["print.css"]
html_show_sourcelink = False
html_copy_source = False
html_show_copyright = False
copybutton_exclude = ".linenos, .gp, .go"
"""The button copies what one types: no prompts and no output."""

ORDER = (
    "first_episode",
    "bistability_by_hand",
    "past_the_fold",
    "own_controller",
    "own_friction_law",
    "own_rig",
    "fleet",
    "drift",
    "ppo_in_two_minutes",
    "agent_against_lqg",
    "plan_on_copies",
    "calibrate_a_twin",
    "deploy_loop",
    "offline_data",
    "sweep_on_ray",
    "figure_for_a_paper",
)
"""Examples from the first steps on; others come behind."""


class InOrder:
    """The place of an example in the gallery, as sphinx-gallery asks for it."""

    def __init__(self, _folder: str) -> None: ...

    def __call__(self, filename: str) -> tuple[int, str]:
        """The place of a file, by name."""
        name = Path(filename).stem
        return (ORDER.index(name) if name in ORDER else len(ORDER), name)


SMALL = {"ppo_in_two_minutes.py": ["150000"], "sweep_on_ray.py": ["local"]}
"""Arguments with which examples are run for their page, where they take much longer, or start Ray, without."""

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "generated/gallery",
    "filename_pattern": r"\.py$" if find_spec("minari") else r"(?<!offline_data)\.py$",
    "within_subsection_order": InOrder,
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
