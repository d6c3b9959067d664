"""The page: one HTML file that stands alone, with its style, its program and its data inside.

An arm inline in a notebook: a picture that can be turned, in a frame that asks for nothing from anywhere.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import ConfigurationError
from rankdrop.families import Family, upright_start
from rankdrop.kinematics import link_poses
from rankdrop.lists import flat_map
from rankdrop.local import blame, lost_directions, singular_values
from rankdrop.report.content import Content, first_view, limit_range, page_data, robot_data, slider_range, standing
from rankdrop.report.sections import (
    STANDING,
    corank_tables,
    exact_section,
    line_section,
    scroll_box,
    slice_section,
    solid_section,
    verification_section,
    workspace_section,
)
from rankdrop.results import Analysis
from rankdrop.robot import Array, Robot, near_ideal
from rankdrop.sections import html
from rankdrop.task import Task, link_index, resolve_task
from rankdrop.text import aspects_line, lost_sentences, near_line, notes_words, slow_configurations, slow_line
from rankdrop.tolerances import DEFAULT, SLOW, SLOW_TURN
from rankdrop.version import VERSION

SCRIPTS = ("kinematics.js", "scene.js", "arm.js", "solid.js", "page.js")
"""The page's program, in this order."""
_NAVIGATION = (
    ("see", "Arm"), ("tables", "Families"), ("exact", "Conditions"), ("slices", "Joint space"),
    ("workspace", "Workspace"), ("lines", "σ"), ("checks", "Checks"),
)  # fmt: skip
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"

_SAVE = (
    '<div class="save screen" role="group" aria-label="downloads">Download: '
    '<button id="save-csv">families (CSV)</button> <button id="save-json">analysis (JSON)</button> '
    '<button id="save-png">this picture (PNG)</button></div>'
)

_SCRIPTS = ("kinematics.js", "scene.js", "arm.js", "inline.js")
_LEFT = "<style>footer { display: none; } #arm { display: block; width: 100%; height: 100vh; cursor: grab; }</style>"


def page(content: Content) -> str:
    """The whole page as text. It asks for nothing from anywhere: its own policy forbids it."""
    analysis = content.analysis
    title = f"{analysis.robot.name}: singularities"
    ideal = f'<section id="ideal"><h2>Ideal arm</h2>{scroll_box(html(content.beside), "ideal arm")}</section>'
    sections = (
        _arm(content), _tables(content), exact_section(content), ideal if content.beside else "",
        slice_section(content), solid_section(content), workspace_section(content), line_section(content),
        verification_section(content),
    )  # fmt: skip
    whole = "".join(sections)
    there = [(target, name) for target, name in _NAVIGATION if f'<section id="{target}"' in whole]
    links = "".join(f'<a href="#{target}">{name}</a>' for target, name in there)
    body = f'{_header(content)}<nav aria-label="sections"><div>{links}</div></nav><main>{whole}</main>'
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
    encoded = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    encoded = encoded.replace("<", "\\u003c")  # no name in it can end the script
    script, style = ("\n".join(asset(name) for name in names) for names in (scripts, styles))
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><link rel="icon" href="data:,">'
        f"<style>{style}</style></head><body>{body}"
        f"<footer>rankdrop {escape(version)}. This page stands alone: it loads nothing from "
        "anywhere.</footer>"
        f'<script type="application/json" id="data">{encoded}</script>'
        f"<script>\n(() => {{\n{script}\n}})();\n</script></body></html>"
    )


def header(
    title: str, css: str, sentence: str, facts: Iterable[tuple[str, str]], above: str = "", below: str = ""
) -> str:
    """The head of a page: title (HTML), verdict, facts, and HTML above and below the facts."""
    cells = "".join(f"<div><dt>{name}</dt><dd>{escape(text)}</dd></div>" for name, text in facts)
    return (
        f'<header><h1>{title}</h1><p class="{css}">{escape(sentence)}</p>{above}'
        f'<dl class="facts">{cells}</dl>{below}</header>'
    )


def asset(name: str) -> str:
    """One of the files that the page is made of."""
    return (resources.files("rankdrop.report") / "assets" / name).read_text(encoding="utf-8")


def _header(content: Content) -> str:
    analysis, verdict = content.analysis, content.verdict
    robot, task, settings = analysis.robot, analysis.task, analysis.settings
    css = "good" if verdict.holds else "bad"
    counts = {summary.corank: len(analysis.of_corank(summary.corank)) for summary in analysis.coranks}
    counted = ", ".join(f"corank {corank}: {count}" for corank, count in counts.items() if count)
    facts = [
        ("families", counted or "none found"),
        ("chain", f"{robot.n} joints, {robot.base} to {robot.tip}"),
        ("task", f"{task.name}: rank {analysis.generic_rank}, redundancy {robot.n - analysis.generic_rank}"),
        ("length scale", f"{settings.length_scale:.4g} m"),
        ("made by", f"rankdrop {settings.version}, seed {settings.seed}"),
    ]
    aspects = aspects_line(analysis.aspects)
    if aspects:
        facts.insert(1, ("aspects", aspects))
    facts.insert(len(facts) - 2, ("slow", slow_configurations(content.slow, SLOW, SLOW_TURN)))
    if analysis.slow is not None:
        facts.insert(len(facts) - 2, ("speed", slow_line(analysis.slow)))
    title = f'{escape(robot.name)} <span class="badge {css}">{verdict.word}</span>'
    about = f'<div class="about">{escape(robot.about or "Kinematic singularities")}</div>'
    return header(title, css, " ".join(verdict.headlines(analysis.answer)), facts, about, _notes(content))


def _notes(content: Content) -> str:
    """Source of the numbers, notes of the analysis and of the arm."""
    analysis, robot = content.analysis, content.analysis.robot
    source = robot.source.reference or robot.source.origin
    numbers = f'<details class="small"><summary>source of the numbers</summary>{escape(source)}</details>'
    notes = numbers if source else ""
    notes += "".join(f"<p class='bad'>{escape(note)}</p>" for note in analysis.notes)
    if content.beside:
        near = None
    else:
        near = near_ideal(robot)
    small = [*notes_words(robot.notes), *([] if near is None else [near_line(near)])]
    notes += "".join(f"<p class='small'>{escape(note)}</p>" for note in small)
    return notes


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
    buttons = "".join(_button(analysis, family, content.titles[family.id]) for family in analysis.families)
    return (
        '<section id="see"><h2>The arm, live</h2><div class="see"><div class="go" role="group" tabindex="0" '
        f'aria-label="families">{buttons}<button id="home">start posture</button></div><div class="stage">'
        '<canvas id="arm" role="img" tabindex="0" aria-label="The arm"></canvas>'
        '<div class="key">One arrow for each lost motion. Solid: translation. Dotted: rotation. A ring about the '
        "foot of an arrow: the two are mixed, as the sentence says. Orange: axes to blame."
        '<span class="screen"> Drag or use the arrow keys to turn, double click to turn back.</span></div></div>'
        '<div class="panel"><div id="verdict" role="status"></div><div id="sigma"></div><div id="facts"></div>'
        f'<div id="ways" role="group" aria-label="ways out"></div>{_limits_box(robot)}{_meshes_box(content)}'
        f'<div class="sliders">{"".join(sliders)}</div></div></div>{_SAVE}</section>'
    )


def _button(analysis: Analysis, family: Family, title: str) -> str:
    word = STANDING[standing(analysis, family)]
    if word:
        note = f' <small class="limit">{word}</small>'
    else:
        note = ""
    return (
        f'<button data-go="{family.id}" aria-pressed="false"><b>{family.id}</b> {escape(title)}{note}</button>'
    )


def _limits_box(robot: Robot) -> str:
    if not any(limit_range(robot, i) for i in range(robot.n)):
        return '<p class="small">No joint limits are known: sliders go all the way round.</p>'
    return '<label class="small screen"><input type="checkbox" id="limits" checked> keep to the joint limits</label>'


def _meshes_box(content: Content) -> str:
    if not content.meshes:
        return ""
    count = sum(len(mesh.faces) for mesh in content.meshes)
    return (
        '<label class="small screen"><input type="checkbox" id="meshes" checked> links as the file draws them '
        f"(simplified, {count:,} triangles)</label>"
    )


def _tables(content: Content) -> str:
    cards, titles = [], content.titles
    for family, words in zip(content.analysis.families, content.blame_words, strict=True):
        sentences = lost_sentences(family.lost_freedoms)
        lost = "".join(f"<p>{escape(text)}</p>" for text in sentences)
        title = titles[family.id]
        seen = f"The arm in {family.id}, {title}. Lost, an arrow each: {'; '.join(sentences)}."
        if words:
            blame = f'<p class="small">{escape("; ".join(words))}</p>'
        else:
            blame = ""
        cards.append(
            f'<div class="card"><canvas data-still="{family.id}" role="img" aria-label="{escape(seen)}">'
            f"</canvas><h4>{family.id}&ensp;{escape(title)}</h4>{lost}{blame}"
            f'<button data-go="{family.id}" data-far>show above</button></div>'
        )
    if cards:
        shown = f'<h3>The arm at each witness</h3><div class="cards">{"".join(cards)}</div>'
    else:
        shown = ""
    return (
        '<section id="tables"><h2>Families of singularities</h2><p>Every row is a set of configurations at which the '
        "arm loses freedoms, with the conditions on its joints. Corank is the number of freedoms lost.</p>"
        f"{corank_tables(content.analysis_with_conditions)}{shown}</section>"
    )


@dataclass(frozen=True, eq=False)
class ArmView:
    """An arm at one configuration, which a notebook shows as a picture to be turned.

    Attributes:
        robot, task: the arm.
        q: (n,) [rad, m].
        height: of the picture [px].
    """

    robot: Robot
    task: Task
    q: Array
    height: int = 420

    def page(self) -> str:
        """The picture as an HTML page that stands alone."""
        lost, blamed = self._lost()
        words = f"The arm {self.robot.name}; arrow keys turn it"
        body = f'{_LEFT}<canvas id="arm" role="img" tabindex="0" aria-label="{escape(words)}"></canvas>'
        data = {"robot": robot_data(self.robot, self.task), "view": first_view(self.robot), "q": self.q.tolist(),
                "arrows": lost, "blamed": blamed}  # fmt: skip
        return whole_page(self.robot.name, body, data, _SCRIPTS, version=VERSION)

    def _lost(self) -> tuple[list[dict[str, Any]], list[int]]:
        """Arrows of what is lost at q in the base frame, and the joints to blame; none where q is regular."""
        sigma = singular_values(self.robot, self.q, self.task)
        corank = int((sigma <= DEFAULT.singular).sum())
        if not corank:
            return [], []
        frame = self.task.frame
        axes = link_poses(self.robot, self.q)[link_index(frame.axes, len(self.robot.joints), "axes"), :3, :3]
        turned = lost_directions(self.robot, self.q, self.task, corank).reshape(-1, 2, 3) @ axes.T
        blamed = blame(self.robot, self.q, self.task)
        numbers = sorted(set(flat_map(lambda circuit: circuit.numbers, blamed)))
        return [{"v": v.tolist(), "w": w.tolist(), "faint": False} for v, w in turned], numbers

    def _repr_html_(self) -> str:
        return (
            f'<iframe title="{escape(self.robot.name)}" sandbox="allow-scripts" srcdoc="{escape(self.page())}" '
            f'style="width: 100%; height: {self.height}px; border: 0"></iframe>'
        )


def arm_view(robot: Robot, at: ArrayLike | Family | None = None, task: Task | str | None = None) -> ArmView:
    """The arm to be turned in a notebook; where it is singular, with what is lost and the joints to blame.

    Args:
        robot: the arm.
        at: (n,) a configuration [rad, m], or a family, which is shown at its witness; None for a good posture.
        task: as `rankdrop.task.resolve_task` takes it.

    Raises:
        ConfigurationError: `at` does not have one finite number for each joint.
        TaskError: no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> arm_view(open_robot("ur5")).q.shape
        (6,)
    """
    resolved = resolve_task(task, robot)
    where = at.witness if isinstance(at, Family) else at
    q = upright_start(robot, resolved) if where is None else np.array(where, dtype=np.float64)
    if q.shape != (robot.n,) or not np.isfinite(q).all():
        raise ConfigurationError("a configuration has one finite number for each joint", where=f"robot {robot.name!r}",
                                 got=f"shape {q.shape}", allowed=f"({robot.n},)")  # fmt: skip
    return ArmView(robot, resolved, q)
