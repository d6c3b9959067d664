"""What a reader takes away from the page: the families as CSV, the analysis as JSON."""

from __future__ import annotations

import csv
from io import StringIO
from typing import Any

import numpy as np

from rankdrop.report.content import Content, standing
from rankdrop.text import conditions_of, joint_cell, joint_symbol


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
        cells = [joint_cell(family, number, kind).replace("\n", ", ") for number, kind in enumerate(kinds, start=1)]
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
