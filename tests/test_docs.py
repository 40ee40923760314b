"""Every Python example in the README and in docstrings runs."""

import doctest
import importlib
import pkgutil
import re
from pathlib import Path

import pytest

import baselines
import drillrig_env

ROOT = Path(__file__).parents[1]
MADE = ("generated", "_build")  # by `make docs`
PARTS = ("findings.md", "notes.md")  # of pages
PAGES = [
    ROOT / "README.md",
    *(
        page
        for page in sorted((ROOT / "docs").rglob("*.md"))
        if not set(page.relative_to(ROOT).parts) & set(MADE + PARTS)
    ),
]
CLIENTS = re.compile(r"^(?:import|from) (minari|skrl|torchrl)\b", re.MULTILINE)
BLOCKS = [
    pytest.param(
        block, id=f"{page.relative_to(ROOT)}-{i}", marks=[pytest.mark.clients] if CLIENTS.search(block) else []
    )
    for page in PAGES
    if page.name != "datasets.md"  # whose examples need a data set: tests/clients/test_dataset.py
    for i, block in enumerate(re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL))
]
MODULES = sorted(
    module.name
    for package in (drillrig_env, baselines)
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
)


@pytest.mark.parametrize("block", BLOCKS)
def test_example_runs(block, tmp_path, monkeypatch):
    for library in CLIENTS.findall(block):
        pytest.importorskip(library, reason="needs the extra clients")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    quick = block.replace("2_000_000", "20_000")  # the training example, shortened
    exec(compile(quick, "example", "exec"), {})


@pytest.mark.parametrize("module", ["drillrig_env", "baselines", *MODULES])
def test_docstring_examples(module):
    assert doctest.testmod(importlib.import_module(module)).failed == 0


def test_links_between_pages_lead_somewhere():
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            if not set(Path(target).parts) & set(MADE):
                assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_every_picture_has_a_text():
    for page in PAGES:
        assert not re.findall(r"!\[\s*\]\(.*?\)", page.read_text(encoding="utf-8")), page.name


def test_architecture_names_every_room():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    drawn = page + (ROOT / "docs" / "images" / "house.svg").read_text(encoding="utf-8")
    rooms = [path.name for path in (ROOT / "drillrig_env").iterdir() if (path / "__init__.py").exists()]
    assert [room for room in rooms if f"{room}/" not in drawn] == []


def test_the_citation_has_the_version():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {drillrig_env.__version__}\n" in citation
