"""The page of a judged path: the arm playing it, its stretches by verdict, and its numbers under a cursor.

A judged path for papers and reports: distance, σ and joint rates along it, its stretches coloured.
"""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from rankdrop.kinematics import pose
from rankdrop.local import generic_rank
from rankdrop.path import CROSSING, FREE, TOO_NEAR, TOUCHING, UNDECIDED, PathCheck, Place, Stretch
from rankdrop.report.chart import legend_outside
from rankdrop.report.content import LIVE, first_view, robot_data
from rankdrop.report.figures import new_figure
from rankdrop.report.page import header, whole_page
from rankdrop.robot import Array
from rankdrop.sections import html
from rankdrop.text import free_words, place_text, stretch_place
from rankdrop.version import VERSION

if TYPE_CHECKING:
    from matplotlib.figure import Figure


TONES = {FREE: "#009E73", CROSSING: "#D55E00", TOUCHING: "#CC79A7", UNDECIDED: "#B07D00"}
"""Of the stretches, after Okabe and Ito; meetings carry a mark as well, so that no colour has to be told apart."""
_MARKS = {CROSSING: "X", TOUCHING: "v", UNDECIDED: "s"}

SCRIPTS = ("kinematics.js", "scene.js", "arm.js", "player.js")
INKS = {FREE: "--good", CROSSING: "--bad", TOUCHING: "--lost4", UNDECIDED: "--near", TOO_NEAR: "--near"}
"""Of the stretches; meetings carry a mark as well, so that no colour has to be told apart."""
_LISTED = 60  # stretches that have a button
_DIGITS = 7  # of joint values and numbers


def path_figure(check: PathCheck) -> Figure:
    """Distance to the nearest known family, σ_r, and the share of the velocity limits, over time or rows.

    Args:
        check: from `check_path`.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    at, _, series = _series(check)
    bounds = {"distance": check.options.min_distance, "rate / limit": 1.0}
    drawn = new_figure((6.4, 0.6 + 1.3 * len(series)), "a figure of a path")
    for k, (name, unit, values) in enumerate(series):
        axes = drawn.add_subplot(len(series), 1, k + 1)
        _colour(axes, check, legend=k == 0)
        axes.plot(at, values, color="black", lw=1.0)
        if bounds.get(name):
            axes.axhline(bounds[name], color="black", lw=0.7, ls=":")
        axes.set_ylabel(f"{name} [{unit}]" if unit else name, fontsize=8)
        axes.set(ylim=(0, None), xlim=(at[0], max(at[-1], at[0] + 1e-9)))
        axes.tick_params(labelsize=7, labelbottom=k == len(series) - 1)
    if series:
        axes.set_xlabel("row" if check.profile.time is None else "time [s]", fontsize=8)
    drawn.suptitle(f"{check.robot.name}: {check.verdict}", fontsize=9)
    drawn.tight_layout()
    return drawn


def _colour(axes: Any, check: PathCheck, *, legend: bool) -> None:
    seen: set[str] = set()
    for stretch in check.stretches:
        (low, high), tone = (_x(stretch.start), _x(stretch.end)), TONES[stretch.verdict]
        axes.axvspan(low, high, color=tone, alpha=0.18, lw=0)
        if stretch.verdict in _MARKS:
            if stretch.verdict in seen:
                label = None
            else:
                label = stretch.verdict
            axes.plot([(low + high) / 2], [0.0], _MARKS[stretch.verdict], color=tone, ms=6, clip_on=False, zorder=5,
                      label=label)  # fmt: skip
            seen.add(stretch.verdict)
    if legend and seen:
        legend_outside(axes)


def path_page(check: PathCheck) -> str:
    """The whole page as text: it stands alone.

    Args:
        check: from `check_path` or `check_poses`.
    """
    robot = check.robot
    css = "good" if check.holds else "bad"
    facts = [
        ("rows", f"{check.rows:,}, {check.options.interpolate} between them"),
        ("proven free", f"{free_words(check)} of its length"),
        ("task", f"{check.task.name}, σ with lengths divided by {check.length_scale:.4g} m"),
    ]
    if check.curve.times is not None:
        facts.insert(1, ("lasts", f"{check.curve.times[-1] - check.curve.times[0]:.6g} s"))
    title = f'{escape(robot.name)} <span class="badge {css}">{escape(check.verdict)}</span>'
    body = f'{header(title, css, check.sentence, facts)}<main>{_stage(check)}<section id="words"><h2>In words</h2>'
    body += f'<div class="scroll words">{html(check.sections(full=True)[1:])}</div></section></main>'
    return whole_page(
        f"{robot.name}: a path", body, _data(check), SCRIPTS, ("page.css", "player.css"),
        version=VERSION,
    )  # fmt: skip


def _stage(check: PathCheck) -> str:
    buttons = "".join(
        f'<button data-stretch="{i}"><i class="dot" style="background:var({INKS[stretch.verdict]})"></i>'
        f"<b>{escape(stretch.verdict)}</b> {escape(_place(check, stretch) or 'no family known')}<br>"
        f'<span class="small">{escape(_when(stretch))}</span></button>'
        for i, stretch in sorted(enumerate(check.stretches[:_LISTED]), key=lambda pair: _order(pair[1]))
    )
    left = len(check.stretches) - _LISTED
    if left > 0:
        more = f'<span class="small">and {left} more</span>'
    else:
        more = ""
    legend = "".join(
        f'<span><i class="dot" style="background:var({INKS[kind]})"></i>{escape(kind)}</span>'
        for kind in (FREE, CROSSING, TOUCHING, UNDECIDED)
        if any(stretch.verdict == kind for stretch in check.stretches)
    )
    return (
        '<section id="see"><h2>The arm on its path</h2><div class="see"><div class="go" aria-label="stretches">'
        f'{buttons}{more}</div><div class="stage"><canvas id="arm" tabindex="0" aria-label="The arm in three '
        'dimensions; drag to turn"></canvas><div class="key">The line is the way of the tip. Faint arrow: the '
        'direction that would be lost first; solid: translation, dotted: rotation, with a ring: mixed.</div></div>'
        '<div class="readout"><div id="verdict"></div>'
        '<dl id="numbers"></dl></div></div><div class="player"><button id="play" aria-label="play">▶ play</button>'
        '<input type="range" id="at" min="0" max="1" step="any" value="0" aria-label="place on the path">'
        f'<output id="place"></output></div><div class="legend">{legend}</div>'
        '<div id="plots"></div></section>'
    )


def _place(check: PathCheck, stretch: Stretch) -> str:
    """The singularity of a stretch as the sentence at the top of the page names it; "" where none is known."""
    if stretch.name:
        return stretch_place(check, stretch)
    return ""


def _order(stretch: Stretch) -> tuple[bool, int, float]:
    """What meets a singularity first, worst first; then free stretches as they follow each other."""
    free = stretch.verdict == FREE
    if free:
        return (free, stretch.start.row, stretch.start.share)
    return (free, 0, 0.0)


def _when(stretch: Stretch) -> str:
    """From where to where: "row 3 – row 4.5", "at 1.25 s"."""
    start, end = map(place_text, (stretch.start, stretch.end))
    if start == end:
        return f"at {start}"
    return f"{start} – {end}"


def _data(check: PathCheck) -> dict[str, Any]:
    robot, profile, timed = check.robot, check.profile, check.curve.times is not None
    extra = [
        stretch.closest.place for stretch in check.stretches
        if stretch.verdict != FREE or stretch.closest.distance < np.inf
    ]  # fmt: skip
    position = np.unique([*profile.position.tolist(), *(place.row + place.share for place in extra)])
    stretch, share = check.curve.split(position - 1.0)
    q = check.curve.at(stretch, share)
    time = check.curve.time(stretch, share)
    x = position if time is None else time
    at, family, series = _series(check)
    tool = check.tool
    poses = None
    if tool is not None:
        poses = _list_values(np.interp(position - 1.0, np.arange(len(tool.place)), tool.place))
    return {
        "robot": robot_data(robot, check.task),
        "view": first_view(robot),
        "generic_rank": generic_rank(robot, check.task),
        "live_tolerance": LIVE,
        "timed": timed,
        "x": _list_values(x),
        "row": _list_values(position),
        "pose": poses,
        "q": [_list_values(configuration) for configuration in q],
        "tip": [_list_values(point) for point in np.atleast_3d(pose(robot, q))[:, :3, 3]],
        "at": _list_values(at),
        "family": family,
        "min_distance": check.options.min_distance,
        "series": [{"name": name, "unit": unit, "values": _list_values(values)} for name, unit, values in series],
        "stretches": [
            {
                "start": _x(stretch.start), "end": _x(stretch.end), "closest": _x(stretch.closest.place),
                "verdict": stretch.verdict, "ink": INKS[stretch.verdict], "name": _place(check, stretch),
                "family": stretch.family, "free": stretch.verdict == FREE,
            }
            for stretch in check.stretches
        ],
    }  # fmt: skip


def _series(check: PathCheck) -> tuple[Array, list[str | None], list[tuple[str, str, Array]]]:
    """Places of the plots, the nearest family at each, and what is drawn: the profile, and every closest approach."""
    profile = check.profile
    if profile.time is None:
        at = profile.position
    else:
        at = profile.time
    known = [stretch for stretch in check.stretches if np.isfinite(stretch.closest.distance)]
    place = np.array([_x(stretch.closest.place) for stretch in known])
    order = np.argsort(np.concatenate([at, place]), kind="stable")
    ids = [*_ids(check), *(stretch.family or None for stretch in known)]
    values = (
        ("distance", "rad", profile.distance, [stretch.closest.distance for stretch in known]),
        ("σ", "", profile.sigma, [stretch.closest.sigma for stretch in known]),
        ("rate / limit", "", profile.rates, np.interp(place, at, profile.rates) if len(known) else []),
    )
    series = [(name, unit, np.concatenate([every, more])[order]) for name, unit, every, more in values
              if np.isfinite(every).any()]  # fmt: skip
    return np.concatenate([at, place])[order], [ids[k] for k in order.tolist()], series


def _ids(check: PathCheck) -> list[str | None]:
    """The nearest family at each place of the profile."""
    return [None if i < 0 else check.profile.ids[i] for i in check.profile.family.tolist()]


def _x(place: Place) -> float:
    if place.time is None:
        return place.row + place.share
    return place.time


def _list_values(values: Array) -> list[float | None]:
    return [float(f"{x:.{_DIGITS}g}") if np.isfinite(x) else None for x in np.asarray(values).tolist()]
