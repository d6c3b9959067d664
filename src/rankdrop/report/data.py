"""What the page's own program is told, as plain data: the chain, the families, the sets in three joints.

And what a reader takes away from the page: the families as CSV, the analysis as JSON.
"""

from __future__ import annotations

import csv
from html import escape
from io import StringIO
from math import isfinite, pi
from typing import Any

import numpy as np

from rankdrop.families import Solid
from rankdrop.family import Family
from rankdrop.local import sampling_box, skeleton, start_posture
from rankdrop.problem import wrap
from rankdrop.report.content import Content, standing
from rankdrop.report.meshes import meshes_data
from rankdrop.report.ways import Way
from rankdrop.results import Analysis
from rankdrop.robot import Array, Robot, lost_told, reach
from rankdrop.task import Task
from rankdrop.text import JOINT, columns, conditions_of, joint_symbol, one_line

LIVE = 1e-7
"""σ at or below this is shown as zero while a slider moves [1]: the page's own arithmetic is good to 1e-9 there."""
_DIGITS = 3  # of points in the cube of three joints


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
        "start": start_posture(analysis.robot, analysis.task).tolist(),
        "families": [
            _family(family, numbers, words, out, analysis.robot) | {"standing": standing(analysis, family)}
            for family, numbers, words, out in blame
        ],
        "solids": [_solid(one, content.colours[one.family], analysis.robot) for one in content.solids],
        "meshes": meshes_data(content.meshes),
        "downloads": downloads(content),
    }


def limit_range(robot: Robot, index: int) -> tuple[float, float] | None:
    """Both limits of a joint [rad, m]; None where it has not both: its slider then keeps `slider_range`."""
    low, high = float(robot.lower[index]), float(robot.upper[index])
    return (low, high) if isfinite(low) and isfinite(high) and low < high else None


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
        "reach": _size(robot, points),
        "rows": list(task.rows),
        "length_scale": task.scale(robot),
        "frame": {
            "axes": frame.axes if frame.axes >= 0 else count,
            "origin": frame.origin if frame.origin >= 0 else count,
            "point": list(frame.point),
        },
    }


def _size(robot: Robot, points: Array) -> float:
    """The size that the arm is drawn in [m]: its reach, the base included."""
    return max(reach(robot), float(np.linalg.norm(points[0])), 1e-6)


def first_view(robot: Robot) -> dict[str, float]:
    """From above where every axis is upright (planar arms, SCARA), else from the front and a little above."""
    upright = all(abs(abs(joint.screw[5]) - 1) < 1e-9 for joint in robot.joints if np.any(joint.screw[3:]))
    slides = any(not np.any(joint.screw[3:]) for joint in robot.joints)
    return {"turn": -1.2, "tilt": 1.05} if upright and not slides else {"turn": -0.9, "tilt": 0.38}


def _rows(pose: Array) -> list[float]:
    rows: list[float] = pose[:3].ravel().tolist()
    return rows


def _family(
    family: Family, numbers: tuple[int, ...], words: tuple[str, ...], ways: tuple[Way, ...], robot: Robot
) -> dict[str, Any]:
    return {
        "id": family.id,
        "name": family.name,
        "corank": family.corank,
        "witness": list(family.witness),
        "lost_directions": family.lost_directions.tolist(),
        "blamed": list(numbers),
        "told": family_html(family, words, robot),
        "ways": [{"label": one.label, "after": one.after, "q": list(one.q)} for one in ways],
    }


def family_html(family: Family, words: tuple[str, ...], robot: Robot) -> str:
    """A family in sentences: what is lost, in which axes, and who is to blame."""
    lost = "".join(
        f'<li><span class="dot" style="background:var(--lost{1 + index % 4})"></span>{escape(one)}</li>'
        for index, one in enumerate(family.lost_words)
    )
    blame = f"<p><b>To blame:</b> {escape('; '.join(words))}</p>" if words else ""
    note = lost_told(robot, family.lost_words)
    axes = f'<p class="small">{escape(note)}</p>' if note else ""
    return f"<b>{escape(family.name)}</b><ul>{lost}</ul>{axes}{blame}"


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


def pieces(line: Array) -> list[Array]:
    """A curve that runs on past ±π, cut and brought back into the cube."""
    inside = wrap(line)
    jumps = np.flatnonzero((np.abs(np.diff(inside, axis=0)) > pi).any(axis=1)) + 1
    return [piece for piece in np.split(inside, jumps) if len(piece) > 1]


def finite(value: float) -> float | None:
    """A number for JSON, None where it is infinite."""
    return value if isfinite(value) else None


def families_csv(content: Content) -> str:
    """One row per family: id, name, corank, dimension, a column per joint, conditions, loss, tests, witness.

    Angles of the witness are in degrees, slides in metres; the joints' columns are those of the tables (× any value,
    c coupled, else the values in rad or m).
    """
    analysis = content.analysis
    derived = () if content.exact is None else content.exact.families
    robot = analysis.robot
    kinds = [str(joint.kind) for joint in robot.variables]
    joints = [joint_symbol(number, kind) for number, kind in enumerate(kinds, start=1)]
    units = ["deg" if joint.unit == "rad" else joint.unit for joint in robot.variables]
    buffer = StringIO()
    rows = csv.writer(buffer, lineterminator="\n")
    rows.writerow([
        "id", "family", "corank", "dimension", *joints, "conditions", "lost", "singular", "tested", "explained",
        "fresh points", "joint limits", *(f"witness {name} [{unit}]" for name, unit in zip(joints, units, strict=True)),
    ])  # fmt: skip
    for family in analysis.families:
        cells = [one_line(one, family) for one in columns(robot, family.corank) if one.holds == JOINT]
        conditions = "; ".join(text for _, text in conditions_of(family, analysis.exact, derived))
        at = np.where([unit == "deg" for unit in units], np.degrees(family.witness), family.witness)
        rows.writerow([
            family.id, family.name, family.corank, family.dimension, *cells, conditions, "; ".join(family.lost_words),
            family.soundness.agree, family.soundness.tested, family.explained.agree, family.explained.tested,
            standing(analysis, family), *(f"{value:.6g}" for value in at),
        ])  # fmt: skip
    return buffer.getvalue()


def downloads(content: Content) -> dict[str, Any]:
    """File name, CSV and JSON record, for the page's program."""
    name = "".join(one if one.isalnum() or one in "-_" else "-" for one in content.analysis.robot.name)
    return {"file": name, "csv": families_csv(content), "record": content.analysis.to_dict()}
