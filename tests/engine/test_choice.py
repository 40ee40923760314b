"""Engines by their words, and what processes must have in common."""

import sys

import pytest

from drillrig_env.command_line import Failed
from drillrig_env.engine import Local, engine_at, likeness, used


def test_local_is_this_process_unless_jobs_are_told():
    assert engine_at("local").here
    assert (engine_at("local", 3).jobs, engine_at("local", 3).here) == (3, False)


@pytest.mark.parametrize(
    "word",
    ["laptop", "ray://", "ray://host", "ray://:10001", "ray://host:port", "ray://host:²", "ray://host:70000", ""],
)
def test_other_words_are_refused_with_those_that_are_known(word):
    with pytest.raises(ValueError, match=r"is not known; allowed: local, ray, auto .*, or ray://HOST:PORT"):
        engine_at(word)


def test_no_jobs_are_refused():
    with pytest.raises(ValueError, match="jobs = 0 is not allowed"):
        engine_at("local", 0)


@pytest.mark.parametrize(
    ("word", "said"), [("ray", "--on ray"), ("auto", "--on auto"), ("ray://a:1", "--on ray://a:1")]
)
def test_without_ray_it_is_said_what_to_install(word, said, monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(ImportError, match=rf"{said} needs ray; in a clone of DrillRig: pip install -e '.\[scale\]'"):
        engine_at(word)


def test_an_engine_that_is_given_stays_and_another_ends(monkeypatch):
    ended = []
    monkeypatch.setattr(Local, "end", lambda self: ended.append(self))
    own = Local()
    with used(own) as engine:
        assert engine is own
    assert ended == []
    with used(None) as engine:
        assert engine.here
    assert ended == [engine]


def test_what_differs_between_machines_is_named():
    own = likeness.likeness()
    likeness.check_alike(own, "the machine a")
    assert {"drillrig", "kernels", "numpy", "Python"} <= set(own)
    other = {**own, "kernels": "0123", "numpy": "1.0"}
    with pytest.raises(Failed, match=rf"the machine a does not .* kernels {own['kernels']} and not 0123, numpy"):
        likeness.check_alike(other, "the machine a")


def test_a_changed_kernel_changes_the_likeness(monkeypatch):
    before = likeness.likeness()["kernels"]
    monkeypatch.setattr(likeness, "stamp_of", lambda file: "f" * 64)
    assert likeness.likeness.__wrapped__()["kernels"] != before
