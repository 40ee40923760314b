"""The page of a calibration: one file of HTML with its pictures in it, to be sent on or printed as it is."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

from drillrig_env.calibrate.report import Report
from drillrig_env.evaluation.provenance import in_words


def page(report: Report, pictures: Mapping[Path, str]) -> str:
    """The page as text; `pictures` are PNG files with their captions."""
    calibration = report.calibration
    notes = [f"{one.source}: {'; '.join(one.notes)}. SHA-256 {one.digest}" for one in calibration.records]
    figures = {path.stem: _figure(path, caption) for path, caption in pictures.items()}
    parts = [f"<h2>What it means</h2>{_list(report.sentences())}{figures.pop('borders', '')}"]
    for title, headings, rows in report.tables():
        parts.append(f"<h2>{escape(title)}</h2>{_table(headings, rows)}")
        if title == "Parameters":
            parts += [figures.pop(name, "") for name in ("intervals", "correlations")]
    parts += ["<h2>Measured beside the model</h2>", *figures.values()]
    made = f"{in_words(report.summary()['made'])}. Seed {calibration.seed}."
    return _PAGE.format(parts="\n".join(parts), notes=_list(notes), command=escape(report.command), made=escape(made))


def _list(sentences: Sequence[str]) -> str:
    return f"<ul>{''.join(f'<li>{escape(one)}</li>' for one in sentences)}</ul>"


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{escape(one)}</th>" for one in headings)
    body = "\n".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{head}</tr>\n{body}</table>"


def _figure(path: Path, caption: str) -> str:
    content = base64.b64encode(path.read_bytes()).decode("ascii")
    image = f'<img src="data:image/png;base64,{content}" alt="{escape(caption)}">'
    return f"<figure>{image}<figcaption>{escape(caption)}</figcaption></figure>"


_PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>A calibrated rig</title>
<style>body {{ font: 16px/1.5 sans-serif; max-width: 52em; margin: 2em auto; padding: 0 1em }}
table {{ border-collapse: collapse; font-size: 90% }}
td, th {{ border-bottom: 1px solid #ccc; padding: .2em .8em; text-align: left }}
img {{ max-width: 100% }} figure {{ margin: 1.5em 0; break-inside: avoid }}
figcaption {{ color: #555; font-size: 90% }} code {{ overflow-wrap: anywhere }}</style>
<h1>A calibrated rig</h1>
{parts}
<h2>Records</h2>{notes}
<p>Made by <code>{command}</code></p><p>{made}</p></html>
"""
