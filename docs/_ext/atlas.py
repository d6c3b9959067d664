"""The atlas: for each arm of the catalogue a page with its picture and families, and its report beside it.

Made from the analyses that are shipped; nothing is analysed here. `-D atlas_arms=ur10,ur10e` makes the pages of these
arms alone, in a fifth of the time. `RANKDROP_ATLAS` in the environment says of which
arms a report is made as well: `all` (some minutes, what a site to be read has), names separated by commas, or nothing,
the default. A report that the same version has made is kept.
"""

from __future__ import annotations

import os
from collections import defaultdict
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from docutils import nodes
from pages import write_pages
from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

import rankdrop
from rankdrop.families import Family, LostFreedom, upright
from rankdrop.local import drawn_at
from rankdrop.options import on_command_line
from rankdrop.report.content import content
from rankdrop.report.page import page as report_page
from rankdrop.results import Analysis
from rankdrop.results.known import shipped
from rankdrop.robot import CatalogEntry, near_ideal, reach, search_catalog
from rankdrop.robot.ideal import Near
from rankdrop.text import joint_cell, joint_symbol, lost_note, lost_sentences
from rankdrop.text.robots import hold_words, near_line, near_text

_MOST = 40  # rows of a page; a calibrated arm has hundreds
_SIZE = 150  # of a picture [px]
_ORPHAN = "---\norphan: true\n---\n\n"  # in the sidebar of every page they would make the site slow to build
_TURN, _TILT = -0.9, 0.38  # of the view [rad], as in the report


def wanted(entries: list[CatalogEntry]) -> set[str]:
    """Names of the arms that get a report."""
    asked = os.environ.get("RANKDROP_ATLAS", "")
    return {one.name for one in entries} if asked == "all" else set(filter(None, asked.split(",")))


def title(entry: CatalogEntry) -> str:
    """What people search for."""
    name = entry.about.split(",")[0] if entry.about else entry.name
    return f"Singularities of the {name}"


def picture(found: Analysis) -> str:
    """The arm at the witness of its first family, as SVG."""
    robot = found.robot
    family = upright(robot, found.task, found.families[0]) if found.families else None
    arm = drawn_at(robot, np.zeros(robot.n) if family is None else np.array(family.witness))
    right = np.array([-np.sin(_TURN), np.cos(_TURN), 0.0])
    toward = np.array([np.cos(_TURN) * np.cos(_TILT), np.sin(_TURN) * np.cos(_TILT), np.sin(_TILT)])
    axes = np.stack([right, -np.cross(toward, right)])
    links, joints = arm.links @ axes.T, arm.middles @ axes.T
    middle = (links.min(axis=0) + links.max(axis=0)) / 2
    scale = 0.84 * _SIZE / max(float(np.ptp(links, axis=0).max()), 0.3 * reach(robot))
    links, joints = ((points - middle) * scale + _SIZE / 2 for points in (links, joints))
    way = " ".join(f"{x:.1f},{y:.1f}" for x, y in links)
    dots = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5.5" fill="#56697d"/>' for x, y in joints)
    base = f'<rect x="{links[0, 0] - 9:.1f}" y="{links[0, 1] - 2:.1f}" width="18" height="5" fill="currentColor"/>'
    words = "" if family is None else f" at a singularity: {family.name}"
    return (
        f'<svg viewBox="0 0 {_SIZE} {_SIZE}" width="{_SIZE}" height="{_SIZE}" role="img" '
        f'aria-label="{escape(found.robot.name + words)}">{base}<polyline points="{way}" fill="none" '
        f'stroke="#a3b1c0" stroke-width="7" stroke-linejoin="round" stroke-linecap="round"/>{dots}</svg>'
    )


def arm_page(entry: CatalogEntry, found: Analysis, alike: list[CatalogEntry], drawn: str, report: bool) -> str:
    """The page of one arm, in Markdown."""
    robot = found.robot
    heads = [joint_symbol(number, str(joint.kind)) for number, joint in enumerate(robot.variables, start=1)]
    rows = [
        f"| {family.id} | {_cell(family.name)} | "
        + " | ".join(_cell(_joined(joint_cell(family, number, str(joint.kind))))
                     for number, joint in enumerate(robot.variables, start=1))
        + f" | {family.dimension} | {_cell(_lost(family))} |"
        for family in found.families[:_MOST]
    ]  # fmt: skip
    table = "\n".join([
        "| | family | " + " | ".join(heads) + " | dim | lost |", "|" + "---|" * (len(heads) + 4), *rows,
    ])  # fmt: skip
    rest = len(found.families) - len(rows)
    more = f"\n\n{rest} more: `rankdrop analyze {entry.name} --all`." if rest else ""
    coranks = ", ".join(
        f"{len(found.of_corank(one.corank))} of corank {one.corank}" for one in found.coranks
        if found.of_corank(one.corank)
    )  # fmt: skip
    near = near_ideal(robot)
    parts = [
        f"# {title(entry)}",
        f"{entry.about}. {_maker(entry)}{coranks or 'No families were found, which is no proof.'}. "
        f"{found.verdict.sentence.split(';')[0]}.",
        "```{raw} html\n" + drawn + "\n```",
        f'<a href="{entry.name}-report.html">The report: the arm in 3-D, conditions, workspace</a>' if report else "",
        f"```console\nrankdrop analyze {entry.name}\nrankdrop report {entry.name}\nrankdrop view {entry.name}\n```",
        "× any value; c coupled with others: `rankdrop conditions " + entry.name + "` has the formula. Values in rad, "
        "with degrees where they are not simple. What is lost at one configuration, in base and tool axes: `rankdrop "
        f"explain {entry.name} --deg --q …`.",
        table + more,
        _cell(lost_note(robot, [lost for family in found.families[:_MOST] for lost in _kept(family)])),
        _near_line(near),
        "Alike, with families of the same names: "
        + ", ".join(f"[{one.name}]({one.name}.md)" for one in alike[:12]) + "." if alike else "",
        f"Numbers: {entry.source}" if entry.source else "",
    ]
    return _ORPHAN + "\n\n".join(filter(None, parts)) + "\n"


def _kept(family: Family) -> list[LostFreedom]:
    """The lost motions that are the same everywhere on a family."""
    return [one for one in family.lost_freedoms if one.everywhere]


def _lost(family: Family) -> str:
    """What is lost on a family; of what changes along it only how many directions."""
    told, rest = list(lost_sentences(_kept(family))), len(family.lost_freedoms) - len(_kept(family))
    if rest:
        told.append(f"{rest} direction{'s' * (rest > 1)} that change{'s' * (rest == 1)} along the family")
    return "; ".join(told)


def _maker(entry: CatalogEntry) -> str:
    return f"Maker: {entry.maker}. Families: " if entry.maker else "Families: "


def _joined(cell: str | tuple[str, ...]) -> str:
    """The values of a cell in one line."""
    return cell if isinstance(cell, str) else ", ".join(cell)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("*", "\\*").replace("_", "\\_")


def index(
    entries: list[CatalogEntry], found: dict[str, Analysis], alike: dict[str, list[CatalogEntry]],
    pictures: dict[str, str],
) -> str:  # fmt: skip
    """The page that lists them, with a box that narrows the list while one types."""
    rows = []
    for entry in entries:
        families = found[entry.name].families
        names = (one.name for one in families[:_MOST])
        near = near_ideal(found[entry.name].robot)
        gained = map(hold_words, near.gained) if near else ()
        words = " ".join([entry.name, entry.maker, entry.about, *entry.aliases, *names, *gained])
        rows.append(
            f'<tr data-words="{escape(words.lower())}"><td>{pictures[entry.name]}</td>'
            f'<td><a href="{entry.name}.html">{escape(entry.name)}</a><br>{escape(entry.about)}</td>'
            f"<td>{escape(entry.maker or 'from the literature')}</td><td>{_kinds(found[entry.name])}</td>"
            f"<td>{_near(near_text(near) if near else '', alike[entry.name])}</td></tr>"
        )
    return (
        "# Atlas\n\nThe singularities of every arm of the catalogue, from the analyses that come with rankdrop.\n\n"
        "```{raw} html\n"
        '<p><label>Name, maker, or words of a family: '
        '<input id="atlas-words" type="search" autocomplete="off"></label> '
        f'<span id="atlas-count" role="status">{len(entries)} arms</span></p>\n'
        '<table class="atlas"><thead><tr><th>picture</th><th>arm</th><th>maker</th><th>families</th>'
        f"<th>what is near</th></tr></thead><tbody>{''.join(rows)}</tbody></table>\n"
        f"<script>{_SEARCH}</script>\n```\n"
    )


def _kinds(found: Analysis) -> str:
    """The names of corank 1, and how many there are of the others."""
    first = found.of_corank(1)
    told = [escape(one.name) for one in first[:4]]
    if len(first) > 4:
        told.append(f"{len(first) - 4} more")
    told += [
        f"{len(found.of_corank(one.corank))} of corank {one.corank}"
        for one in found.coranks if one.corank > 1 and found.of_corank(one.corank)
    ]  # fmt: skip
    return "<br>".join(told) or "none found"


def _near_line(near: Near | None) -> str:
    """Which ideal arm is near, and the option of the command line that takes it; "" for none."""
    if near is None:
        return ""
    with on_command_line():
        return near_line(near)


def _near(near: str, alike: list[CatalogEntry]) -> str:
    """The ideal arm that this one nearly is, and arms whose families have the same names."""
    told = [escape(near)] if near else []
    if alike:
        links = ", ".join(f'<a href="{one.name}.html">{one.name}</a>' for one in alike[:4])
        told.append(f"alike: {links}" + (f" and {len(alike) - 4} more" if len(alike) > 4 else ""))
    return "<br>".join(told)


_SEARCH = (
    "document.getElementById('atlas-words').addEventListener('input', (event) => {"
    "const words = event.target.value.toLowerCase().split(/\\s+/).filter(Boolean); let count = 0;"
    "for (const row of document.querySelectorAll('.atlas tbody tr')) {"
    "row.hidden = !words.every((word) => row.dataset.words.includes(word)); count += !row.hidden; }"
    "document.getElementById('atlas-count').textContent = `${count} ${count === 1 ? 'arm' : 'arms'}`; });"
)


def write(app: Sphinx) -> None:
    """Write the pages into the source folder, where they have changed."""
    asked = app.config.atlas_arms
    entries = [entry for entry in search_catalog("") if not asked or entry.name in asked]
    found = {entry.name: shipped(entry.name) for entry in entries}
    kinds: dict[tuple[str, ...], list[CatalogEntry]] = defaultdict(list)
    for entry in entries:
        kinds[tuple(family.name for family in found[entry.name].families)].append(entry)
    alike = {}
    for entry in entries:
        same = kinds[tuple(family.name for family in found[entry.name].families)]
        others = (one for one in same if one is not entry)
        alike[entry.name] = sorted(others, key=lambda one: one.maker != entry.maker)  # those of the maker first
    reports = wanted(entries)
    pictures = {entry.name: picture(found[entry.name]) for entry in entries}
    pages = {"index.md": index(entries, found, alike, pictures)}
    for entry in entries:
        name = entry.name
        pages[f"{name}.md"] = arm_page(entry, found[name], alike[name], pictures[name], name in reports)
    write_pages(Path(app.srcdir) / "atlas", pages)


def write_reports(app: Sphinx, error: Exception | None) -> None:
    """Write the reports beside the pages; one that this version has made is kept."""
    if error is not None or app.builder.format != "html":
        return
    folder = Path(app.outdir) / "atlas"
    for name in sorted(wanted(list(search_catalog("")))):
        target = folder / f"{name}-report.html"
        made = f"<footer>rankdrop {rankdrop.__version__}."
        if not target.exists() or made not in target.read_text(encoding="utf-8"):
            target.write_text(report_page(content(shipped(name))), encoding="utf-8")


def share_the_sidebar(
    app: Sphinx, page: str, template: str, context: dict[str, Any], tree: nodes.document | None
) -> None:
    """Make the sidebar once for all pages of arms: none of them is in it, so that it is the same in each.

    For every page of a site the tree of all pages is copied and resolved, two fifths of the work of a build.
    """
    if not page.startswith("atlas/") or page == "atlas/index":
        return
    made: dict[str, str] = app.builder.__dict__.setdefault("sidebars_of_arms", {})
    toctree = context["toctree"]

    def shared(**options: Any) -> str:
        asked = repr(sorted(options.items()))
        if asked not in made:
            made[asked] = toctree(**options)
        return made[asked]

    context["toctree"] = shared


def setup(app: Sphinx) -> ExtensionMetadata:
    """Write the pages before the source folder is read, and the reports when the site is there."""
    app.add_config_value("atlas_arms", [], "env", [list])
    app.connect("builder-inited", write)
    app.connect("build-finished", write_reports)
    app.connect("html-page-context", share_the_sidebar, priority=100)  # before the theme asks for the tree
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
