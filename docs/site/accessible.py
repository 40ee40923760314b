"""What theme and gallery leave out for those who use a keyboard or a screen reader, put into the built pages."""

from __future__ import annotations

import re
from pathlib import Path

_MENDED = (
    (r"<pre>", '<pre tabindex="0">'),  # what is wider than the page is scrolled by keys
    (r'<div class="table-wrapper([^"]*)">', r'<div class="table-wrapper\1" tabindex="0">'),
    (r'<aside class="sidebar-drawer">', '<aside class="sidebar-drawer" aria-label="Pages">'),
    (r'<aside class="toc-drawer">', '<aside class="toc-drawer" aria-label="On this page">'),
    (r'<th class="head([^"]*)"><p></p></th>', r'<td class="head\1"></td>'),  # a heading of nothing
    (r'(<a class="reference internal" href="[^"]*")(><span class="doc">([^<]*)</span></a></p>\s*'
     r'<div class="sphx-glr-thumbnail-title">)', r'\1 aria-label="\3"\2'),  # its own text is not shown
    (r'<div id="search-results"></div>', '<h1>Search</h1>\n<div id="search-results"></div>'),
)  # fmt: skip


def mend(text: str) -> str:
    """A page as it should be; mending it again changes nothing."""
    for pattern, better in _MENDED:
        if better not in text:
            text = re.sub(pattern, better, text)
    return text


def mend_pages(site: Path) -> None:
    """Mend every page in the folder of a site."""
    for path in site.rglob("*.html"):
        text = path.read_text(encoding="utf-8")
        if (better := mend(text)) != text:
            path.write_text(better, encoding="utf-8")
