"""The built site in a real browser: axe finds nothing, nothing is fetched, and pages read without JavaScript."""

from pathlib import Path

import pytest

pytest.importorskip("playwright", reason="needs the extra room-test")
pytest.importorskip("axe_playwright_python", reason="needs the extra room-test")

from axe_playwright_python.sync_playwright import Axe

from benchmarks.browser import chromium

SITE = Path(__file__).parents[1] / "docs" / "_build" / "html"
PAGES = (
    "index",
    "tutorials/first_run",
    "how-to/reward",
    "scale",
    "generated/api/drillrig_env",
    "generated/api/baselines",
    "generated/gallery/index",
    "generated/gallery/first_episode",
    "search",
)

pytestmark = [
    pytest.mark.room,
    pytest.mark.skipif(not (SITE / "index.html").exists(), reason="there is no site: `make docs` builds it"),
]


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_nothing_and_nothing_is_fetched(name, browser):
    for scheme, width in (("light", 1280), ("dark", 400)):
        page = browser.new_page(color_scheme=scheme, viewport={"width": width, "height": 900})
        asked = []
        page.on("request", lambda request, asked=asked: asked.append(request.url))
        page.goto((SITE / f"{name}.html").as_uri())
        found = Axe().run(page).response["violations"]
        page.close()
        assert [(one["id"], one["nodes"][0]["html"]) for one in found] == []
        assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []


def test_pages_read_without_javascript(browser):
    page = browser.new_page(java_script_enabled=False)
    page.goto((SITE / "environment.html").as_uri())
    assert page.get_by_role("heading", level=1).is_visible()
    assert page.get_by_role("table").first.is_visible()
    page.close()


def test_search_finds_a_page(browser):
    page = browser.new_page()
    page.goto((SITE / "search.html").as_uri() + "?q=bistable")
    page.get_by_role("link", name="Control of stick-slip").first.wait_for(timeout=20_000)
    page.close()
