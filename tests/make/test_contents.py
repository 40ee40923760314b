"""The list of contents of a long page: its links lead to its headings, commands and blocks of code aside."""

import doctest
import re
from pathlib import Path

import pytest

from docs.make import contents
from docs.make.contents import anchor, with_contents

DOCS = Path(__file__).parents[2] / "docs"


def test_its_example_holds():
    assert doctest.testmod(contents).failed == 0


def test_parts_of_a_part_stand_behind_its_link_and_code_is_no_heading():
    text = "# P\n\n## A\n\n### X, suite `one`: w\n\n### X: who wins\n\n```sh\n## no\n```\n\n## B\n\n### alone\n"
    listed = with_contents(text).partition("## A")[0]
    assert listed == "# P\n\n- [A](#a): [`one`](#x-suite-one-w), [who wins](#x-who-wins)\n- [B](#b)\n\n"
    assert with_contents("# P\n\nshort\n") == "# P\n\nshort\n"


@pytest.mark.parametrize("page", ["results.md", "agents.md", "performance.md"])
def test_long_pages_have_one_whose_links_lead_somewhere(page):
    text = (DOCS / page).read_text(encoding="utf-8")
    anchors = {anchor(heading) for heading in re.findall(r"^#+ (.+)$", text, re.MULTILINE)}
    listed = re.findall(r"^- \[.*$", text.partition("\n## ")[0], re.MULTILINE)
    assert len(listed) >= 7
    assert {target for line in listed for target in re.findall(r"\]\(#(.*?)\)", line)} <= anchors
