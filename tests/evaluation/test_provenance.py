"""What pages say of how something was made."""

import platform

import numpy as np

from drillrig_env.evaluation.provenance import in_words, provenance, when_and_where


def test_machine_and_versions_are_this_ones():
    made = provenance()
    assert made["versions"]["numpy"] == np.__version__
    assert made["python"] == platform.python_version()
    assert platform.machine() in made["machine"]


def test_words_name_what_is_installed_and_no_more():
    made = {"date": "2026-01-02", "python": "3.12", "machine": "Linux", "versions": {"numpy": "2.0", "torch": None}}
    assert when_and_where(made) == "2026-01-02, Linux"
    assert in_words(made) == "2026-01-02, Linux, Python 3.12, numpy 2.0"
    assert in_words(made, {"jax": "0.4", "numpy": "2.1"}).endswith("numpy 2.1, jax 0.4")
