"""The lower sections of the page: joint space, workspace, σ along lines, verification.

How the numbers were checked is told in sentences with counts, seeds and tolerances.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from math import degrees

from rankdrop.families import Slice
from rankdrop.report.charts import (
    COLOURS,
    image_chart,
    names_of,
    projections,
    slice_chart,
    spread,
    sweep_chart,
    workspace_chart,
)
from rankdrop.report.content import Content
from rankdrop.report.tables import scrolled
from rankdrop.results import sampled, unseen
from rankdrop.robot import Robot

_WIDE = 0.5  # a family whose tips are in more than this share of the cells that they could meet fills a region


def slice_section(content: Content) -> str:
    """Planes of joint space."""
    robot = content.analysis.robot
    figures = "".join(
        f"<figure>{slice_chart(robot, plane, content.colours)}<figcaption>{_slice_words(content, plane)}</figcaption>"
        "</figure>"
        for plane in content.slices
    )
    if not figures:
        told = '<section id="slices"><h2>Joint space</h2><p>No family with conditions to draw.</p></section>'
        return told if content.analysis.families else ""
    rank = content.analysis.generic_rank
    return (
        f'<section id="slices"><h2>Joint space</h2><p>Two joints move, the others are held. Shade: σ<sub>{rank}</sub>, '
        "stronger where it is small. Curves and dots: the families, solved from their conditions; every point drawn "
        f'was checked in the Jacobian.</p><div class="figures">{figures}</div></section>'
    )


def _slice_words(content: Content, plane: Slice) -> str:
    robot = content.analysis.robot
    keys = " ".join(_key(content, trace.family) for trace in plane.traces)
    held = _held(robot, plane.q, plane.joints)
    filled = "".join(f" The whole slice lies in {one}." for one in plane.filled)
    return f"{keys} Through a point of <b>{plane.family}</b>{': ' + held if held else ''}.{filled}"


def _held(robot: Robot, q: Iterable[float], moving: Sequence[int]) -> str:
    """Values of the joints that stand still: "θ2 = 30°, q3 = 0.2 m"."""
    parts = []
    for number, (joint, name, value) in enumerate(zip(robot.variables, names_of(robot), q, strict=True), start=1):
        if number not in moving:
            parts.append(f"{name} = {degrees(value):.4g}°" if joint.unit == "rad" else f"{name} = {value:.4g} m")
    return ", ".join(parts).replace("-", "−")


def _key(content: Content, family: str) -> str:
    index = content.colours[family] % COLOURS
    return f'<span class="dot" style="background:var(--f{1 + index})"></span><b>{family}</b>'


def solid_section(content: Content) -> str:
    """Families that tie three joints together."""
    if not content.solids:
        return ""
    robot, figures = content.analysis.robot, []
    names = names_of(robot)
    for number, one in enumerate(content.solids, start=1):
        axes = ", ".join(names[joint - 1] for joint in one.joints)
        held = _held(robot, one.q, one.joints)
        what = _curves(len(one.curves), one.closed) if one.curves else f"a surface, {len(one.triangles):,} triangles"
        figures.append(
            f'<figure><canvas id="solid{number}" role="img" tabindex="0" aria-label="The set of {one.family} in the '
            f'cube of {axes}: {what}. Arrow keys turn it."></canvas>'
            f"<figcaption>{_key(content, one.family)} in ({axes}): {what}, up to whole turns"
            f"{'; held: ' + escape(held) if held else ''}.<span class='screen'> Drag to turn.</span></figcaption>"
            "</figure>"
        )
        for text in projections(robot, one, content.colours[one.family]) if one.curves else []:
            figures.append(f"<figure>{text}<figcaption>{_key(content, one.family)} projected.</figcaption></figure>")
    return (
        '<section id="solids"><h3>In three joints</h3><p>Families that tie three joints together, as curves or '
        f'surfaces in the cube of these joints (−π … π).</p><div class="figures">{"".join(figures)}</div></section>'
    )


def _curves(count: int, closed: int) -> str:
    many = "s" if count > 1 else ""
    return f"{count} closed curve{many}" if closed == count else f"{count} curve{many}, {closed} of them closed"


def workspace_section(content: Content) -> str:
    """The workspace with the images of the families."""
    section = content.workspace
    figures = []
    if len(section.walls):
        share = f"{int(section.one_sided.sum()):,} of {len(section.walls):,}"
        figures.append(
            f"<figure>{workspace_chart(section)}<figcaption>Grey: where the tip can be ({section.count:,} random "
            "configurations). Dots: postures in which the position of the tip loses a direction. <b>Dark</b>: to "
            f"second order no motion from that posture crosses the wall ({share}): boundaries of the workspace and of "
            'voids, barriers inside. <b class="bad">Orange</b>: the arm passes by changing its posture.'
            "</figcaption>"
            "</figure>"
        )
    names = {family.id: family.name for family in content.analysis.families}
    for family, points in section.images:
        if not len(points):
            continue
        fills = spread(section, points) > _WIDE
        words = "can occur wherever there are dots, it depends on the posture" if fills else "occurs at these places"
        figures.append(
            f"<figure>{image_chart(section, points, content.colours[family])}<figcaption>{_key(content, family)} "
            f"{escape(names[family])}: {words} ({len(points):,} members).</figcaption></figure>"
        )
    if not figures:
        return ""
    about = "in its plane" if section.section.planar else "in section: distance from axis 1, and height along it"
    return (
        f'<section id="workspace"><h2>Workspace</h2><p>The tip {about}. Limits of turning joints are ignored, as they '
        f'are for the families.</p><div class="figures">{"".join(figures)}</div></section>'
    )


def line_section(content: Content) -> str:
    """Each joint swept through each witness."""
    analysis = content.analysis
    rank = analysis.generic_rank
    if not analysis.families:
        return ""
    parts = []
    for family, swept in zip(analysis.families, content.sweeps, strict=True):
        charts = "".join(sweep_chart(analysis.robot, one, family.corank) for one in swept)
        parts.append(f"<h3>{family.id}&ensp;<small>{escape(family.name)}</small></h3><div class='lines'>{charts}</div>")
    return (
        '<section id="lines"><h2>σ along lines</h2><p>Each joint turns in full, or slides its travel, through the '
        f'witness of a family (dashed line). <b class="bad">Bold</b>: the singular values that vanish there, '
        f"σ<sub>{rank}</sub> and up; thin: the next one. Where the bold line stays at zero, that joint does not lead "
        f"out.</p>{''.join(parts)}</section>"
    )


def verification_section(content: Content) -> str:
    """What was checked, how often, with which tolerances and seeds."""
    items = "".join(f"<li>{escape(text)}</li>" for text in checks(content))
    tolerances = "".join(
        f"<tr><td class='words'>{name}</td><td class='num'>{value:g}</td></tr>"
        for name, value in content.analysis.settings.tolerances.to_dict().items()
    )
    return (
        f'<section id="checks"><h2>How this was checked</h2><ul class="checks">{items}</ul>'
        "<p>These are tests on samples, not proofs. A corank that was not found is not thereby shown to be absent.</p>"
        f"<details><summary>tolerances</summary>{scrolled(f'<table>{tolerances}</table>', 'tolerances')}</details>"
        f"<p class='{'good' if content.verdict.holds else 'bad'}'>{escape(content.verdict.sentence)}</p>"
        "</section>"
    )


def checks(content: Content) -> Iterator[str]:
    """One sentence for each check; the residuals are evaluated anew while the report is made."""
    analysis = content.analysis
    settings, again = analysis.settings, analysis.residual()
    where = "within the joint limits" if settings.limits else "in the whole joint space, joint limits ignored"
    yield f"Search: {settings.starts:,} random starts for each corank {where}; seed {settings.seed}."
    if analysis.families:
        yield sampled(analysis)
        yield (
            f"Evaluated again for this report: at the witnesses the equations leave {again.equation:.1e} at most, the "
            f"singular values that have to vanish {again.sigma:.1e} at most."
        )
    if missed := unseen(analysis):
        yield missed
    last = analysis.coranks[-1] if analysis.coranks else None
    if last is not None and not last.converged:
        met = "" if last.smallest_near_miss is None else f"; the smallest σ met was {last.smallest_near_miss:.4g}"
        yield f"Corank {last.corank}: none found of {last.starts:,} starts{met}. That is no proof of absence."
    yield from _drawn(content)
    yield f"Singular values have no unit: translations are divided by {settings.length_scale:.4g} m."


def _drawn(content: Content) -> Iterator[str]:
    curves = sum(len(line) for plane in content.slices for trace in plane.traces for line in trace.curves)
    points = sum(len(trace.points) for plane in content.slices for trace in plane.traces)
    solid = sum(len(one.vertices) + sum(map(len, one.curves)) for one in content.solids)
    images = sum(len(points) for _, points in content.workspace.images)
    singular = content.analysis.settings.tolerances.singular
    yield (
        f"Drawn: {curves + points:,} points of slices, {solid:,} of sets in three joints and {images:,} members of "
        f"families in the workspace, each with σ ≤ {singular:g} in the Jacobian (seed {content.workspace.seed})."
    )
    if content.exact is not None and content.exact.families:
        ranks = [family.rank_check for family in content.exact.families]
        agree, tested = sum(one.agree for one in ranks), sum(one.tested for one in ranks)
        word = "nothing was left unfinished" if content.exact.complete else "not finished within its time limit"
        yield (
            f"Exact conditions: the rank modulo a prime is as claimed at {agree:,} of {tested:,} random points, and "
            f"{content.exact.explained.agree:,} of {content.exact.explained.tested:,} singular configurations lie on a "
            f"family; {word}."
        )
