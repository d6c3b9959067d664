"""What a report shows, worked out once: everything the page and the figures draw.

Ways out of a witness, as the buttons of the page.

What the page's own program is told, as plain data: the chain, the families, the sets in three joints.

And what a reader takes away from the page: the families as CSV, the analysis as JSON.

Shapes of links for the page: so few triangles that they can be drawn without a graphics card, and sent by mail.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape as quoted
from io import StringIO
from math import isfinite, pi
from typing import Any

import numpy as np

from rankdrop import conditions
from rankdrop.distance import NearShare, Workspace, slow_share, workspace
from rankdrop.errors import MissingExtraError, RobotError
from rankdrop.families import (
    VIEW,
    Family,
    Slice,
    Solid,
    Sweep,
    Verdict,
    solids,
    sweeps,
    telling_slices,
    upright,
    upright_start,
    with_exact,
)
from rankdrop.lists import flat_map
from rankdrop.local import (
    LARGEST_CHAIN,
    blame,
    circuits_at,
    escape,
    generic_rank,
    make_all,
    sampling_box,
    skeleton,
)
from rankdrop.problem import Problem
from rankdrop.report.chart import pieces
from rankdrop.results import Analysis, Conditions, Idealised, known_conditions
from rankdrop.robot import Array, Mesh, Robot, reach
from rankdrop.sections import Section
from rankdrop.task import Task
from rankdrop.text import (
    JOINT,
    columns,
    conditions_of,
    family_label,
    inside_limits,
    joint_symbol,
    lost_note,
    lost_sentences,
    motion,
    moved_section,
    of_analysis,
    one_line,
    place_name,
    place_parts,
    short,
    there_section,
)
from rankdrop.verbs import nearby

_SINGLE = 3  # joints alone that are offered, the best first


Way = tuple[str, str, tuple[float, ...]]
"""A motion that restores the full rank: its name, "joint 5 +5.7°", what it gives, "σ6 = 0.017", and where it leads."""

Progress = Callable[[str, int, int], None]
"""progress(label, done, total)."""
EXACT_SECONDS = 8.0
"""Time limit of the exact conditions; what was derived by then is shown."""
EXACT_POINTS = 200
"""Singular configurations that the exact families have to explain, corank 1."""
_PARTS = 5
_EDGE = 1e-9  # a joint this far beyond a limit stands on it [rad, m]
_WITH_WAYS = 60  # of a calibrated arm's hundreds of families no reader asks for more

MOST = 6_000
"""Triangles of all links together: about 150 kB of the page."""
_GROWS = 1.15  # by how much cells grow until there are few enough triangles
_LEVELS = 8191  # steps of a coordinate over the size of its mesh: 0.1 mm in a metre

LIVE = 1e-7
"""σ at or below this is shown as zero while a slider moves [1]: the page's own arithmetic is good to 1e-9 there."""
_DIGITS = 3  # of points in the cube of three joints


def ways_out(robot: Robot, task: Task, family: Family) -> tuple[Way, ...]:
    """The best direction and the best joints alone that lead out of the witness inside the limits; () for none.

    Where the witness itself is outside the limits no motion counts as inside, and there are none.
    """
    q = np.array(family.witness)
    escapes = escape(robot, q, task)
    rank = f"σ{generic_rank(robot, task)}"
    best, ways = escapes.best_direction, list[Way]()
    for alone in escapes.single:
        if alone.order is None or not alone.within_limits or alone.step == 0 or alone.sigma_after <= escapes.floor:
            continue
        target = q.copy()
        target[alone.number - 1] += alone.step
        told = f"joint {alone.number} {motion(alone.step, robot.variables[alone.number - 1].unit)}"
        ways.append((told, f"{rank} = {short(alone.sigma_after, 2)}", tuple(target.tolist())))
    target = q + best.step * np.array(best.delta)
    direction = ("best direction", f"{rank} = {short(best.sigma_after, 2)}", tuple(target.tolist()))
    usable = best.step and best.restores and best.within_limits
    return (*([direction] if usable else []), *ways[:_SINGLE])


@dataclass(frozen=True, eq=False)
class Content:
    """All that a report shows of one arm.

    Attributes:
        analysis: the families and how they were verified, each with its witness in a posture that can be looked at
            (`rankdrop.viewer.upright.upright`).
        blamed: per family the joints (from 1) of the smallest dependent sets special to its witness, one set for each
            freedom lost.
        blame_words: per family the sets from which all its dependencies follow, in words, after the part of the arm.
        exact: the conditions, exactly; None where they are not to be had, or stand in the analysis (`Analysis.exact`).
        exact_missing: why not; "" otherwise.
        slices: planes of joint space.
        solids: families in the cube of three joints.
        workspace: in section.
        sweeps: per family, each joint swept through its witness.
        ways: per family, the ways out of its witness; of the first 60 families.
        beside: what was moved to make the arm ideal, and what the arm itself does; empty for any other arm.
        meshes: shapes of the links, where the arm's file has them.
        slow: share of the configurations inside the limits at which some straight motion of the tool is slow.
    """

    analysis: Analysis
    blamed: tuple[tuple[int, ...], ...]
    blame_words: tuple[tuple[str, ...], ...]
    exact: Conditions | None
    exact_missing: str
    slices: tuple[Slice, ...]
    solids: tuple[Solid, ...]
    workspace: Workspace
    sweeps: tuple[tuple[Sweep, ...], ...]
    ways: tuple[tuple[Way, ...], ...] = ()
    beside: tuple[Section, ...] = ()
    meshes: tuple[Mesh, ...] = ()
    slow: NearShare | None = None

    @cached_property
    def analysis_with_conditions(self) -> Analysis:
        """The analysis as tables show it: its families have the exact conditions that were derived apart from it."""
        if self.exact is None:
            return self.analysis
        families = with_exact(self.analysis.families, self.exact.families)
        return replace(self.analysis, families=families)

    @cached_property
    def titles(self) -> dict[str, str]:
        """Id of each family -> the part of the arm that is special where it is drawn: "elbow: arm stretched"."""
        robot, task = self.analysis.robot, self.analysis.task
        return {family.id: place_name(robot, task, family) for family in self.analysis.families}

    @cached_property
    def labels(self) -> dict[str, str]:
        """Id of each family -> the parts of the arm that it is about: "shoulder, elbow or wrist"."""
        robot, task = self.analysis.robot, self.analysis.task
        return {family.id: family_label(robot, task, family) for family in self.analysis.families}

    @property
    def verdict(self) -> Verdict:
        """Of the analysis and of the exact conditions beside it: first and last on the page, and the exit code."""
        return of_analysis(self.analysis, self.exact)

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended the derivation of the exact conditions: the page has what was derived by then."""
        joined = self.analysis.exact
        return (self.exact is not None and self.exact.interrupted) or (joined is not None and joined.interrupted)

    @property
    def colours(self) -> dict[str, int]:
        """A number for the colour of each family: those of corank 1 first, the same everywhere in the report."""
        ordered = sorted(self.analysis.families, key=lambda family: family.corank)
        return {family.id: index for index, family in enumerate(ordered)}


def content(
    analysis: Analysis, *, exact: bool = True, exact_seconds: float = EXACT_SECONDS, seed: int = 0,
    made: Idealised | None = None, progress: Progress | None = None, meshes: tuple[Mesh, ...] = (),
) -> Content:  # fmt: skip
    """Work out all that a report of this analysis shows.

    Args:
        analysis: of the arm.
        exact: derive the exact conditions as well.
        exact_seconds: their time limit.
        seed: of every random choice.
        made: how the arm was made, where it is an ideal one.
        progress: called as progress(label, done, total).
        meshes: shapes of the links (`rankdrop.report.content.simplified`).
    """
    robot, task = analysis.robot, analysis.task
    families = tuple(upright(robot, task, family, analysis.families) for family in analysis.families)
    analysis = replace(analysis, families=families)
    tell = progress or (lambda label, done, total: None)
    tell("report", 0, _PARTS)
    if exact:
        derived, missing = _exact(analysis, exact_seconds, seed)
    else:
        derived, missing = (None, "They were not asked for.")
    tell("report", 1, _PARTS)
    planes = telling_slices(robot, task, families, seed=seed)
    tell("report", 2, _PARTS)
    sets = solids(robot, task, families, seed=seed)
    tell("report", 3, _PARTS)
    section = workspace(robot, task, families, seed=seed)
    tell("report", 4, _PARTS)
    to_blame = [_blame(analysis, family) for family in families]
    swept = tuple(sweeps(robot, family.witness, task) for family in families)
    tell("report", 5, _PARTS)
    beside: tuple[Section, ...] = ()
    if made is not None:
        there = nearby(made, task, families, seed=seed)
        beside = (moved_section(made), *([there_section(there)] if there else []))
    return Content(
        analysis=analysis,
        blamed=tuple(numbers for numbers, _ in to_blame),
        blame_words=tuple(words for _, words in to_blame),
        exact=derived,
        exact_missing=missing,
        slices=planes,
        solids=sets,
        workspace=section,
        sweeps=swept,
        ways=tuple(ways_out(robot, task, family) for family in families[:_WITH_WAYS]),
        beside=beside,
        meshes=meshes,
        slow=slow_share(Problem(robot, task), seed=seed)[0],
    )


def standing(analysis: Analysis, family: Family) -> str:
    """How a family stands to the joint limits.

    Returns:
        "inside": the witness is inside; "outside": a value of a pinned joint lies outside at every turn, for all its
        members; "none found": no member inside was met, which is no proof; "" for an arm without limits.
    """
    robot = analysis.robot
    if not (np.isfinite(robot.lower) | np.isfinite(robot.upper)).any():
        return ""
    q = np.array(family.witness)
    if ((q >= robot.lower - _EDGE) & (q <= robot.upper + _EDGE)).all():
        return "inside"
    if inside_limits(family, robot).holds:
        return "none found"
    return "outside"


def _exact(analysis: Analysis, seconds: float, seed: int) -> tuple[Conditions | None, str]:
    """The conditions and "", or None and why not; an analysis that holds them already needs no second derivation."""
    if analysis.exact is not None and any(family.exact for family in analysis.families):
        return None, "They stand in the analysis."
    try:
        if seed:
            shipped = None
        else:
            shipped = known_conditions(analysis.robot, analysis.task)
        exact = shipped or conditions(
            analysis.robot, analysis.task, seconds=seconds, seed=seed, points=EXACT_POINTS, special=False
        )
    except (MissingExtraError, RobotError) as error:
        return None, str(error)
    return exact, ""


def _blame(analysis: Analysis, family: Family) -> tuple[tuple[int, ...], tuple[str, ...]]:
    robot, task = analysis.robot, analysis.task
    if robot.n > LARGEST_CHAIN:
        return (), ()
    nullity = robot.n - analysis.generic_rank + family.corank
    circuits = make_all(circuits_at(robot, family.witness, task), robot.n, nullity)
    smallest = blame(robot, family.witness, task)
    numbers = sorted(set(flat_map(lambda circuit: circuit.numbers, smallest)))
    words = [circuit.words for circuit in circuits]
    if words and (part := place_parts(robot, task, np.asarray(family.witness), family.corank)):
        words[0] = f"{part}: {words[0]}"
    return tuple(numbers), tuple(words)


def simplify_meshes(meshes: Sequence[Mesh], most: int = MOST) -> tuple[Mesh, ...]:
    """The meshes with at most so many triangles together.

    Vertices in one cell of a grid become one, their mean; the cells grow until there are few enough triangles. What
    becomes thinner than a cell vanishes.

    Args:
        meshes: of any size.
        most: triangles of all of them together.
    """
    meshes = [mesh for mesh in meshes if len(mesh.faces)]
    if not meshes:
        return ()
    corners = np.concatenate([mesh.vertices[mesh.faces] for mesh in meshes])  # (F, 3, 3)
    area = np.linalg.norm(np.cross(*np.diff(corners, axis=1).swapaxes(0, 1)), axis=1).sum() / 2
    span = max(float(np.ptp(mesh.vertices, axis=0).max(initial=0.0)) for mesh in meshes)
    if len(corners) <= most:
        cell = 1e-6 * span
    else:
        cell = max(0.5 * np.sqrt(2 * area / most), 1e-6 * span)
    small = [_merge_vertices(mesh, cell) for mesh in meshes]
    while sum(len(mesh.faces) for mesh in small) > most:
        cell *= _GROWS
        small = [_merge_vertices(mesh, cell) for mesh in meshes]
    return tuple(mesh for mesh in small if len(mesh.faces))


def _merge_vertices(mesh: Mesh, cell: float) -> Mesh:
    """Vertices of one cell made one; triangles that have become lines go, and all but one of equal ones."""
    keys = np.floor((mesh.vertices - mesh.vertices.min(axis=0)) / cell).astype(np.int64)
    wide = keys.max(axis=0) + 1
    _, place, count = np.unique(
        (keys[:, 0] * wide[1] + keys[:, 1]) * wide[2] + keys[:, 2], return_inverse=True, return_counts=True
    )
    vertices = np.stack([np.bincount(place, mesh.vertices[:, k]) for k in range(3)], axis=1) / count[:, None]
    faces = place[mesh.faces.astype(np.int64)]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    if len(faces):
        _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
        faces = faces[np.sort(first)]
    used, faces = np.unique(faces, return_inverse=True)
    return Mesh(mesh.link, vertices[used], faces.reshape(-1, 3).astype(np.uint32), mesh.colour)


def meshes_data(meshes: Sequence[Mesh]) -> list[dict[str, Any]]:
    """The meshes for the page's program: whole numbers, a step and a corner to make metres of them."""
    data = []
    for mesh in meshes:
        low = mesh.vertices.min(axis=0)
        step = max(float(np.ptp(mesh.vertices, axis=0).max()), 1e-9) / _LEVELS
        data.append({
            "link": mesh.link,
            "colour": "#{:02x}{:02x}{:02x}".format(*mesh.colour),
            "low": [float(f"{value:.7g}") for value in low],
            "step": float(f"{step:.7g}"),
            "points": np.rint((mesh.vertices - low) / step).astype(int).ravel().tolist(),
            "faces": mesh.faces.ravel().tolist(),
        })  # fmt: skip
    return data


def page_data(content: Content) -> dict[str, Any]:
    """Everything the page's program reads, ready for JSON."""
    analysis = content.analysis
    ways = content.ways + ((),) * (len(analysis.families) - len(content.ways))
    blame = zip(analysis.families, content.blamed, content.blame_words, ways, strict=True)
    return {
        "robot": robot_data(analysis.robot, analysis.task),
        "generic_rank": analysis.generic_rank,
        "live_tolerance": LIVE,
        "view": first_view(analysis.robot),
        "start": upright_start(analysis.robot, analysis.task).tolist(),
        "families": [
            _family(family, numbers, words, out, analysis.robot, content.titles[family.id])
            | {"standing": standing(analysis, family)}
            for family, numbers, words, out in blame
        ],
        "solids": [_solid(solid, content.colours[solid.family], analysis.robot) for solid in content.solids],
        "meshes": meshes_data(content.meshes),
        "downloads": downloads(content),
    }


def limit_range(robot: Robot, index: int) -> tuple[float, float] | None:
    """Both limits of a joint [rad, m]; None where it has not both: its slider then keeps `slider_range`."""
    low, high = float(robot.lower[index]), float(robot.upper[index])
    if isfinite(low) and isfinite(high) and low < high:
        return (low, high)
    return None


def slider_range(analysis: Analysis, index: int) -> tuple[float, float]:
    """Ends of a joint's slider without limits: a whole turn, or the travel of a slide with every witness inside."""
    robot = analysis.robot
    if robot.periodic[index]:
        return -pi, pi
    low, high = (float(end[index]) for end in sampling_box(robot, analysis.task, limits=False))
    at = [0.0, *(family.witness[index] for family in analysis.families)]
    return min(low, *at), max(high, *at)


def robot_data(robot: Robot, task: Task) -> dict[str, Any]:
    """The chain and the task as the page's kinematics take them."""
    index = {joint.name: i for i, joint in enumerate(robot.variables)}
    points, drawn = skeleton(robot)
    count = len(robot.joints) + 1
    chain = [
        {
            "kind": str(joint.kind),
            "screw": joint.screw.tolist(),
            "frame": _rows(joint.frame),
            "variable": index[joint.mimic.leader if joint.mimic else joint.name],
            "multiplier": joint.mimic.multiplier if joint.mimic else 1.0,
            "offset": joint.mimic.offset if joint.mimic else 0.0,
            "point": points[i].tolist(),
            "drawn": drawn[i].tolist(),
        }
        for i, joint in enumerate(robot.joints)
    ]
    frame = task.frame
    return {
        "name": robot.name,
        "joints": [
            {"name": joint.name, "kind": str(joint.kind), "limits": limit_range(robot, i)}
            for i, joint in enumerate(robot.variables)
        ],
        "chain": chain,
        "home": _rows(robot.home),
        "reach": max(reach(robot), float(np.linalg.norm(points[0])), 1e-6),
        "rows": list(task.rows),
        "length_scale": task.scale(robot),
        "frame": {
            "axes": frame.axes if frame.axes >= 0 else count,
            "origin": frame.origin if frame.origin >= 0 else count,
            "point": list(frame.point),
        },
    }


def first_view(robot: Robot) -> dict[str, float]:
    """From above where every axis is upright (planar arms, SCARA), else from the front and a little above."""
    upright = all(abs(abs(joint.screw[5]) - 1) < 1e-9 for joint in robot.joints if np.any(joint.screw[3:]))
    slides = any(not np.any(joint.screw[3:]) for joint in robot.joints)
    if upright and not slides:
        return {"turn": -1.2, "tilt": 1.05}
    return {"turn": VIEW, "tilt": 0.38}


def _rows(pose: Array) -> list[float]:
    rows: list[float] = pose[:3].ravel().tolist()
    return rows


def _family(
    family: Family, numbers: tuple[int, ...], words: tuple[str, ...], ways: tuple[Way, ...], robot: Robot,
    title: str,
) -> dict[str, Any]:
    return {
        "id": family.id,
        "name": family.name,
        "title": title,
        "corank": family.corank,
        "witness": list(family.witness),
        "lost_directions": family.lost_directions.tolist(),
        "blamed": list(numbers),
        "facts": family_html(family, words, robot, title),
        "ways": [dict(zip(("label", "after", "q"), way, strict=True)) for way in ways],
    }


def family_html(family: Family, words: tuple[str, ...], robot: Robot, title: str) -> str:
    """A family in sentences: what is lost, in which axes, and who is to blame."""
    lost = "".join(
        f'<li><span class="dot" style="background:var(--lost{1 + index % 4})"></span>{quoted(sentence)}</li>'
        for index, sentence in enumerate(lost_sentences(family.lost_freedoms))
    )
    if words:
        blame = f"<p><b>To blame:</b> {quoted('; '.join(words))}</p>"
    else:
        blame = ""
    note = lost_note(robot, family.lost_freedoms)
    if note:
        axes = f'<p class="small">{quoted(note)}</p>'
    else:
        axes = ""
    return f"<b>{quoted(title)}</b><ul>{lost}</ul>{axes}{blame}"


def _solid(solid: Solid, colour: int, robot: Robot) -> dict[str, Any]:
    kinds = [str(joint.kind) for joint in robot.variables]
    return {
        "family": solid.family,
        "names": [joint_symbol(number, kinds[number - 1]) for number in solid.joints],
        "colour": colour % 8,
        "curves": [piece.round(_DIGITS).tolist() for line in solid.curves for piece in pieces(line)],
        "vertices": solid.vertices.round(_DIGITS).tolist(),
        "triangles": solid.triangles.tolist(),
    }


def families_csv(content: Content) -> str:
    """One row per family: id, name, corank, dimension, a column per joint, conditions, loss, tests, witness.

    Angles of the witness are in degrees, slides in metres; the joints' columns are those of the tables (× any value,
    c coupled, else the values in rad or m).
    """
    analysis = content.analysis_with_conditions
    robot = analysis.robot
    kinds = [str(joint.kind) for joint in robot.variables]
    joints = [joint_symbol(number, kind) for number, kind in enumerate(kinds, start=1)]
    units = ["deg" if joint.unit == "rad" else joint.unit for joint in robot.variables]
    buffer = StringIO()
    rows = csv.writer(buffer, lineterminator="\n")
    rows.writerow([
        "id", "family", "corank", "dimension", *joints, "conditions", "lost", "singular", "tested", "explained",
        "test points", "joint limits", *(f"witness {name} [{unit}]" for name, unit in zip(joints, units, strict=True)),
    ])  # fmt: skip
    for family in analysis.families:
        cells = [one_line(column, family) for column in columns(robot, family.corank) if column.holds == JOINT]
        conditions = "; ".join(text for _, text in conditions_of(family))
        at = np.where([unit == "deg" for unit in units], np.degrees(family.witness), family.witness)
        rows.writerow([
            family.id, family.name, family.corank, family.dimension, *cells, conditions,
            "; ".join(lost_sentences(family.lost_freedoms)), family.soundness.agree, family.soundness.tested,
            family.explained.agree, family.explained.tested, standing(analysis, family),
            *(f"{value:.6g}" for value in at),
        ])  # fmt: skip
    return buffer.getvalue()


def downloads(content: Content) -> dict[str, Any]:
    """File name, CSV and JSON record, for the page's program."""
    name = "".join(letter if letter.isalnum() or letter in "-_" else "-" for letter in content.analysis.robot.name)
    return {"file": name, "csv": families_csv(content), "record": content.analysis.to_dict()}
