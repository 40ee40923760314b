"""The workshop's command: what it takes, refuses, writes and checks."""

import pytest

from docs.make.__main__ import main
from docs.make.page import PAGES, Page


@pytest.fixture
def pages(monkeypatch, tmp_path):
    """Two pages of words, one with a picture; what was done is listed."""
    done = []
    kept = {"words": "one"}

    def take_in(folder, docs):
        done.append(folder.name)
        kept["words"] = folder.name

    made = {
        "plain": Page("words", lambda docs: {docs / "plain.md": "plain\n"}),
        "drawn": Page(
            "more", lambda docs: {docs / "drawn.md": f"{kept['words']}\n"}, lambda docs: done.append("drawn"), take_in
        ),
    }
    monkeypatch.setattr("docs.make.__main__.PAGES", made)
    return done


def test_every_page_is_written_and_then_up_to_date(pages, tmp_path):
    words = ["--docs", str(tmp_path)]
    assert main([*words, "--check"]) == 1
    assert main(words) == 0
    assert (tmp_path / "plain.md").read_text() == "plain\n"
    assert (tmp_path / "drawn.md").read_text() == "one\n"
    assert pages == ["drawn"]
    assert main([*words, "--check"]) == 0
    assert pages == ["drawn"]


def test_only_the_pages_named_are_written_and_checked(pages, tmp_path, capsys):
    assert main(["plain", "--docs", str(tmp_path)]) == 0
    assert not (tmp_path / "drawn.md").exists()
    assert main(["plain", "--check", "--docs", str(tmp_path)]) == 0
    assert main(["--check", "--docs", str(tmp_path)]) == 1
    assert "error: out of date: drawn; run: python -m docs.make drawn" in capsys.readouterr().err


def test_results_are_taken_in_before_the_page_is_written(pages, tmp_path):
    new = [str(tmp_path / "first"), str(tmp_path / "second")]
    assert main(["drawn", "--docs", str(tmp_path), "--no-pictures", "--take-in", *new]) == 0
    assert pages == ["first", "second"]
    assert (tmp_path / "drawn.md").read_text() == "second\n"
    assert main(["plain", "drawn", "--docs", str(tmp_path), "--no-pictures", "--take-in", new[0]]) == 0
    assert (tmp_path / "drawn.md").read_text() == "first\n"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["drwan"], "page 'drwan' is not known; did you mean drawn?"),
        (["plain", "--take-in", "x"], "--take-in is for drawn, one of them"),
        (["drawn", "--check", "--take-in", "x"], "--take-in writes, --check does not"),
    ],
)
def test_what_makes_no_sense_is_refused(pages, words, said, capsys):
    with pytest.raises(SystemExit) as end:
        main(words)
    assert end.value.code == 2
    assert said in capsys.readouterr().err
    assert pages == []


def test_help_names_every_page(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    told = capsys.readouterr().out
    for name, page in PAGES.items():
        assert name in told
        assert page.about in told
