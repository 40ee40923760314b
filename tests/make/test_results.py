"""The page of results: made from what was taken in, and only from that."""

import re
from dataclasses import astuple
from pathlib import Path

import numpy as np
import pytest

from docs.make.__main__ import main
from docs.make.results import COMMAND, PICTURES, draw_pictures, page, stored_results, take_in
from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.store import read, save
from drillrig_env.evaluation.suites import suite
from drillrig_env.evaluation.tables import HARDNESS, all_estimates, estimates, stored_row
from tests.evaluation.conftest import compare

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def docs(comparison, tmp_path_factory):
    folder = tmp_path_factory.mktemp("docs")
    surface = compare([suite("default", 24)], "DrillRigSurface-v0")
    for name, (results, histories) in (("state", comparison), ("surface", surface)):
        save(folder / name, results, histories)
        take_in(folder / name, folder)
    return folder


@pytest.fixture(scope="module")
def stored():
    """What the project's page is made from."""
    return stored_results(DOCS)


@pytest.mark.slow
def test_page_has_every_suite_the_findings_and_its_making(docs):
    (docs / "results" / "findings.md").write_text("Words of a person.\n")
    text = page(docs)
    for words in (
        "## DrillRig-v0: sensors `state`",
        "## DrillRigSurface-v0: sensors `surface`",
        "suite `degraded`",
        "each policy less itself in `default`",
        "## From DrillRig-v0 to DrillRigSurface-v0",
        "Words of a person.",
        "python eval.py",
        "numpy",
        "- `constant`: worst ",
        "- In `default` below ω_c ",
    ):
        assert words in text
    assert text == page(docs)
    assert "nan" not in text


def test_the_pictures_of_the_page_are_drawn(docs, monkeypatch):
    shown = set(re.findall(r"\]\(images/results/(.+)\)", page(docs)))
    assert shown == {
        *(f"DrillRig-v0_{name}.png" for name in PICTURES),
        *(f"DrillRigSurface-v0_{name}.png" for name in PICTURES if "load" not in name),
    }
    monkeypatch.setattr("docs.make.results.PICTURES", {"calming_default": "", "histories_load_below": ""})
    names = {path.name for path in draw_pictures(docs)}
    assert names == {name for name in shown if name.endswith(("calming_default.png", "histories_load_below.png"))}
    for path in (docs / "images" / "results").iterdir():
        assert path.read_bytes().startswith(b"\x89PNG")


def test_results_that_are_not_finished_and_missing_ones_are_refused(comparison, docs, tmp_path, capsys):
    unfinished = read(docs / "state")
    unfinished.estimates = {}
    save(tmp_path, unfinished, Histories())
    with pytest.raises(ValueError, match="not finished"):
        take_in(tmp_path, tmp_path)
    with pytest.raises(SystemExit):
        main(["results", "--docs", str(tmp_path / "none")])
    assert "holds no results" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.skipif(not (DOCS / "results").is_dir(), reason="no results have been taken in")
def test_the_projects_page_is_up_to_date(stored):
    assert (DOCS / "results.md").read_text(encoding="utf-8") == page(DOCS), f"out of date; run: {COMMAND}"
    for results in stored.values():
        suite = next(iter(results.scores))
        for policy, scores in list(results.scores[suite].items())[:2]:
            found = all_estimates({suite: {policy: scores}}, policy)[suite][policy]["main"]
            stored = results.estimates[suite][policy]["main"]
            assert {name: one["value"] for name, one in found.items()} == pytest.approx(
                {name: np.nan if one["value"] is None else one["value"] for name, one in stored.items()}, nan_ok=True
            )


@pytest.mark.skipif(not (DOCS / "results").is_dir(), reason="no results have been taken in")
def test_the_projects_results_have_every_rig_in_a_bin_of_hardness(stored):
    for results in stored.values():
        for name, policies in results.scores.items():
            for policy, scores in policies.items():
                stored = stored_row(results.estimates[name][policy]["hardness"])
                wanted = estimates(scores, HARDNESS.columns)
                assert list(stored) == list(wanted)
                for bin_name, one in wanted.items():  # nan where a bin is empty
                    assert astuple(stored[bin_name]) == pytest.approx(astuple(one), rel=0, abs=0, nan_ok=True)
                assert sum(one.count for one in stored.values()) == len(scores["seed"])
