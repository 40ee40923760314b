"""The site: what is public is documented, pages are made from the records, and broken pages are found."""

import inspect
import re

import pytest

pytest.importorskip("sphinx", reason="needs the extra docs")

import baselines
import drillrig_env
from docs.site import api, commands, outside, records
from docs.site.accessible import mend
from docs.site.check import faults
from docs.site.check import main as check
from docs.site.docstrings import as_markdown
from docs.site.public import arguments_of, documented, fields_said, is_error, modules, names_of, shown_names
from docs.site.used import in_use, named, own_example
from drillrig_env.cli import COMMANDS
from drillrig_env.evaluation.suites import SUITES


def test_every_public_name_is_shown():
    shown = {id(one.value) for one in shown_names().values()}
    for package in (drillrig_env, baselines):
        hidden = [
            name
            for name in package.__all__
            if id(value := getattr(package, name)) not in shown and not inspect.ismodule(value)
        ]
        assert hidden == []
    assert {name.partition(".")[0] for name in modules()} == {"drillrig_env", "baselines"}


@pytest.mark.parametrize("module", modules())
def test_every_page_of_the_code_has_its_names(module):
    page = api.page(module)
    for one in names_of(module):
        assert re.search(rf"{{py:\w+}}.*\b{one.name}\b", page), one.full


def test_docstrings_become_markdown():
    text = "What `f` does, `other` aside.\n\n## Part\n    indented\n\n>>> f(1)\n2\n\nEnd."
    assert as_markdown(text, {"m.f"}, "m") == (
        "What {py:obj}`f <m.f>` does, `other` aside.\n\n**Part**\n    indented\n\n```pycon\n>>> f(1)\n2\n```\n\nEnd."
    )


def test_a_signature_is_as_it_is_written():
    def f(one: "int", *rest: "str", two: "float | None" = None, three: object = object(), **more: "int") -> "bool": ...

    assert api.signature("f", f) == (
        "f(one: int, *rest: str, two: float | None = None, three: object = ..., **more: int) -> bool"
    )


def test_links_that_lead_out_of_the_site_are_mended():
    page = outside.ROOT / "docs" / "agents.md"
    card, folder = "[card](../agents/trained/ppo/README.md)", "[settings](../agents/hyperparams)"
    assert outside.relinked(card, page) == "[card](/generated/agents/ppo.md)"
    assert outside.relinked(folder, page) == "settings"
    assert outside.relinked("[x](../examples/fleet.py)", page) == "[x](/generated/gallery/fleet.rst)"
    assert outside.relinked("[x](environment.md#channels)", page) == "[x](/environment.md#channels)"
    assert outside.relinked("[x](https://a.org/b) [y](#z)", page) == "[x](https://a.org/b) [y](#z)"
    assert outside.relinked("```\n[x](../agents)\n```", page) == "```\n[x](../agents)\n```"


def test_pages_of_records_have_every_record():
    suites, environments, lines = records.suites(), records.environments(), commands.page()
    assert all(f"## `{name}`" in suites for name in SUITES)
    assert all(f"`{name}`" in environments for name in drillrig_env.ENVIRONMENTS)
    assert "v0" in environments.partition("Version history")[2]
    assert all(f"## `drillrig {name}`" in lines for name in COMMANDS)
    assert lines.count("usage: ") >= len(COMMANDS)


@pytest.mark.parametrize(
    ("body", "fault"),
    [
        ('<a href="other.html#there">x</a>', None),
        ('<img src="data:," alt="a curve">', None),
        ('<a href="nowhere.html">x</a>', "links to nowhere.html"),
        ('<a href="other.html#nowhere">x</a>', "no such place"),
        ('<script src="https://cdn.example/x.js"></script>', "fetches https://cdn.example/x.js"),
        ('<link rel="stylesheet" href="//cdn.example/x.css">', "fetches //cdn.example/x.css"),
        ('<img src="gone.png" alt="a curve">', "wants gone.png"),
        ('<img src="data:,">', "picture without a text"),
    ],
)
def test_broken_pages_are_found(body, fault, tmp_path, capsys):
    (tmp_path / "index.html").write_text(f"<html><body>{body}</body></html>")
    (tmp_path / "other.html").write_text('<html><body><p id="there">x</p></body></html>')
    found = list(faults(tmp_path))
    assert bool(found) == bool(fault)
    assert check([str(tmp_path)]) == (1 if fault else 0)
    if fault:
        assert fault in found[0]
        assert fault in capsys.readouterr().err


def test_a_site_that_is_not_there_is_refused(tmp_path, capsys):
    with pytest.raises(SystemExit):
        check([str(tmp_path / "none")])
    assert "has no index.html" in capsys.readouterr().err


def test_every_public_argument_is_named():
    silent = [
        f"{one.label}: {argument}"
        for one in documented()
        for argument in arguments_of(one.value)
        if not re.search(rf"\b{re.escape(argument)}\b", one.said)
    ]
    assert silent == []


def test_what_one_meets_first_has_an_example():
    met = [getattr(drillrig_env, name) for name in drillrig_env.__all__]
    assert [one.__name__ for one in met if callable(one) and ">>> " not in (inspect.getdoc(one) or "")] == []


TOO_LONG = {"drillrig_env.calibrate.choose_law", "drillrig_env.validation.all_checks"}  # for an example
LEFT_BY_COMMANDS = {"drillrig_env.calibrate.Posterior", "drillrig_env.deploy.Log", "drillrig_env.validation.Check"}
CONTRACTS = {"drillrig_env.deploy.Hardware"}  # to be kept, not called


@pytest.mark.slow
def test_every_public_name_is_in_an_example_that_runs():
    functions = {full: one.value for full, one in shown_names().items() if callable(one.value)}
    silent = {full for full, value in functions.items() if not (is_error(value) or own_example(value) or in_use(value))}
    assert silent == TOO_LONG | LEFT_BY_COMMANDS | CONTRACTS


def test_what_code_names_is_found():
    code = (
        "import drillrig_env as dr\nfrom drillrig_env.policy import load as l\ndr.stability.fold_speed(l('lqg'), other)"
    )
    found = named(code)
    assert drillrig_env.stability.fold_speed in found
    assert drillrig_env.policy.load in found
    assert drillrig_env.policy.Policy in found  # which load returns
    assert named("hurwitz_minors(1)", "drillrig_env.stability") == [drillrig_env.stability.hurwitz_minors]


def test_an_argument_that_is_not_named_is_seen():
    class Law:
        """A law of `speed`."""

        def __init__(self, speed, load):
            pass

    assert arguments_of(Law) == ["speed", "load"]
    assert arguments_of(ValueError) == []
    assert fields_said(drillrig_env.Rig).split("\n")[:3] == ["J_1", "J_2", "J_3"]


def test_pages_are_mended_for_keyboards_and_screen_readers():
    thumb = (
        '<a class="reference internal" href="a.html"><span class="doc">A rig</span></a></p>\n'
        '  <div class="sphx-glr-thumbnail-title">A rig</div>'
    )
    once = mend(f'<pre>x</pre><th class="head"><p></p></th><aside class="toc-drawer">{thumb}')
    assert once.startswith('<pre tabindex="0">x</pre><td class="head"></td><aside class="toc-drawer" aria-label=')
    assert 'href="a.html" aria-label="A rig"><span' in once
    assert mend(once) == once
