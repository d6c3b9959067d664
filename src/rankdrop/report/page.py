"""The page: one HTML file that stands alone, with its style, its program and its data inside."""

from __future__ import annotations

import json
from collections.abc import Iterable
from html import escape
from importlib import resources
from typing import Any

from rankdrop.report.content import Content
from rankdrop.report.data import page_data, slider_range
from rankdrop.report.exact import exact_section
from rankdrop.report.sections import (
    line_section,
    slice_section,
    solid_section,
    verification_section,
    workspace_section,
)
from rankdrop.report.tables import corank_tables
from rankdrop.robot import near_ideal
from rankdrop.sections import html

SCRIPTS = ("kinematics.js", "scene.js", "arm.js", "solid.js", "page.js")
"""The page's program, in this order."""
_NAVIGATION = (
    ("see", "Arm"), ("tables", "Families"), ("exact", "Conditions"), ("slices", "Joint space"),
    ("workspace", "Workspace"), ("lines", "σ"), ("checks", "Checks"),
)  # fmt: skip
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"


def page(content: Content) -> str:
    """The whole page as text. It asks for nothing from anywhere: its own policy forbids it."""
    analysis = content.analysis
    title = f"{analysis.robot.name}: singularities"
    links = "".join(f'<a href="#{target}">{name}</a>' for target, name in _NAVIGATION)
    sections = (
        _arm(content), _tables(content), exact_section(content), _beside(content), slice_section(content),
        solid_section(content), workspace_section(content), line_section(content), verification_section(content),
    )  # fmt: skip
    body = f"{_header(content)}<nav><div>{links}</div></nav><main>{''.join(sections)}</main>"
    return whole_page(title, body, page_data(content), SCRIPTS, version=analysis.settings.version)


def whole_page(
    title: str, body: str, data: dict[str, Any], scripts: Iterable[str], styles: Iterable[str] = ("page.css",), *,
    version: str,
) -> str:  # fmt: skip
    """A page that stands alone: its style, its program and its data inside, nothing asked for from anywhere.

    Args:
        title: of the window.
        body: HTML, above the line at the foot.
        data: what the program reads.
        scripts, styles: files of `assets`, in order.
        version: of rankdrop, for the foot.
    """
    told = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    told = told.replace("<", "\\u003c")  # no name in it can end the script
    script, style = ("\n".join(asset(name) for name in names) for names in (scripts, styles))
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><link rel="icon" href="data:,">'
        f"<style>{style}</style></head><body>{body}"
        f"<footer>rankdrop {escape(version)}. This page stands alone: it loads nothing from "
        "anywhere.</footer>"
        f'<script type="application/json" id="data">{told}</script>'
        f"<script>\n(() => {{\n{script}\n}})();\n</script></body></html>"
    )


def asset(name: str) -> str:
    """One of the files that the page is made of."""
    return (resources.files("rankdrop.report") / "assets" / name).read_text(encoding="utf-8")


def _header(content: Content) -> str:
    analysis, verdict = content.analysis, content.verdict
    robot, task, settings = analysis.robot, analysis.task, analysis.settings
    css = "good" if verdict.holds else "bad"
    redundancy = robot.n - analysis.generic_rank
    found = ", ".join(
        f"corank {summary.corank}: {len(rows)}"
        for summary in analysis.coranks
        if (rows := analysis.of_corank(summary.corank))
    )
    facts = [
        ("families", found or "none found"),
        ("chain", f"{robot.n} joints, {robot.base} to {robot.tip}"),
        ("task", f"{task.name}: rank {analysis.generic_rank}, redundancy {redundancy}"),
        ("length scale", f"{settings.length_scale:.4g} m"),
        ("made by", f"rankdrop {settings.version}, seed {settings.seed}"),
    ]
    cells = "".join(f"<div><dt>{name}</dt><dd>{escape(text)}</dd></div>" for name, text in facts)
    source = robot.source.reference or robot.source.origin
    told = f'<details class="small"><summary>source of the numbers</summary>{escape(source)}</details>'
    notes = told if source else ""
    notes += "".join(f"<p class='bad'>{escape(note)}</p>" for note in analysis.notes)
    near = None if content.beside else near_ideal(robot)
    small = [*robot.notes, *([] if near is None else [near.line])]
    notes += "".join(f"<p class='small'>{escape(note)}</p>" for note in small)
    return (
        f'<header><h1>{escape(robot.name)} <span class="badge {css}">{verdict.word}</span></h1>'
        f'<p class="{css}">{escape(verdict.sentence)}</p>'
        f'<div class="about">{escape(robot.about or "Kinematic singularities")}</div>'
        f'<dl class="facts">{cells}</dl>{notes}</header>'
    )


def _arm(content: Content) -> str:
    analysis = content.analysis
    robot = analysis.robot
    sliders = []
    for i, joint in enumerate(robot.variables):
        low, high = slider_range(analysis, i)
        letter = "q" if joint.unit == "m" else "θ"
        sliders.append(
            f'<label class="slider" title="{escape(joint.name)}"><b>{letter}<sub>{i + 1}</sub></b>'
            f'<input type="range" id="slider{i + 1}" min="{low:.6f}" max="{high:.6f}" step="any" value="0" '
            f'aria-label="joint {i + 1}, {escape(joint.name)}"><span id="value{i + 1}"></span></label>'
        )
    buttons = "".join(
        f'<button data-go="{family.id}" aria-pressed="false"><b>{family.id}</b> {escape(family.name)}</button>'
        for family in analysis.families
    )
    return (
        '<section id="see"><h2>The arm, live</h2><div class="see"><div class="go" aria-label="families">'
        f'{buttons}<button id="home">q = 0</button></div><div class="stage">'
        '<canvas id="arm" tabindex="0" aria-label="The arm in three dimensions; drag to turn"></canvas>'
        '<div class="key">Solid arrow: translation lost. Dotted: rotation lost. Orange: axes to blame. Drag to turn, '
        "double click to turn back.</div></div>"
        f'<div><div id="verdict"></div><div id="sigma"></div><div id="told"></div><div class="sliders">'
        f"{''.join(sliders)}</div></div></div></section>"
    )


def _beside(content: Content) -> str:
    if not content.beside:
        return ""
    return f'<section id="ideal"><h2>Ideal arm</h2><div class="scroll">{html(content.beside)}</div></section>'


def _tables(content: Content) -> str:
    cards = []
    for family, words in zip(content.analysis.families, content.blame_words, strict=True):
        lost = "".join(f"<p>{escape(text)}</p>" for text in family.lost_words)
        blame = f'<p class="small">{escape("; ".join(words))}</p>' if words else ""
        cards.append(
            f'<div class="card"><canvas data-still="{family.id}" aria-label="The arm at the witness of {family.id}">'
            f"</canvas><h4>{family.id}&ensp;{escape(family.name)}</h4>{lost}{blame}"
            f'<button data-go="{family.id}" data-far>show above</button></div>'
        )
    return (
        '<section id="tables"><h2>Families of singularities</h2><p>Every row is a set of configurations at which the '
        "arm loses freedoms, with the conditions on its joints. Corank is the number of freedoms lost.</p>"
        f'{corank_tables(content.analysis)}<h3>The arm at each witness</h3><div class="cards">{"".join(cards)}</div>'
        "</section>"
    )
