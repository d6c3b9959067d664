"""Paths through a singularity in words. Records: `rankdrop.path.mend.time_law`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rankdrop.sections import Section
from rankdrop.task import ROWS
from rankdrop.text.joint_values import fixed_point
from rankdrop.text.places import joint_cells, joint_heads
from rankdrop.text.tool_paths import turn_words
from rankdrop.text.words import minus

_THROUGH = {
    "regular": "Not singular: trackable with any smooth time law.",
    "passes": "Trackable through the singularity with s = c t^{order}: the path stands still there for an instant; at "
    "constant speed joint rates grow as |s|^(−{less}/{order}).",
    "tangent": "Trackable through the singularity at any speed: the path is in the image of J to second order.",
    "corner": "Trackable through the singularity with a stop at it, where the joints change direction: s = ± c "
    "t^{twice}.",
    "turns back": "Not trackable through: the path is within reach only {side}. With s = c t^{order} the arm reaches "
    "the singularity and comes back on the path in another posture, at finite joint rates.",
    "not trackable": "Not trackable: no joint motion from this configuration follows the path, on either side of it.",
    "undecided": "Undecided: nothing is settled by terms up to order {highest}.",
}
"""Kind of a path through a singularity -> what it means."""


def through_sentence(through: Any, highest: int) -> str:
    """Whether a tool path leads through a singularity; `highest` is the order up to which terms are compared."""
    if through.turn is not None:
        words = turn_words(through.turn, through.robot, place=False)
        return f"Not trackable from this configuration, but after an internal turn: {words}."
    order, side = through.order or 1, "ahead of it" if through.side > 0 else "before it"
    return _THROUGH[through.kind].format(order=order, less=order - 1, twice=2 * order, side=side, highest=highest)


def through_sections(through: Any, *, deg: bool) -> Iterator[Section]:
    """A tool path through a singularity: the verdict first and last."""
    yield Section(through.sentence)
    rows = ", ".join(f"{ROWS[row]} {value:g}" for row, value in zip(through.task.rows, through.along, strict=True))
    lines = [f"path along {rows} [m, rad], {100 * abs(through.outside):.3g} % of it lost to first order"]
    if len(through.s):
        ends = f"s = {through.s[0]:.4g} to {through.s[-1]:.4g}"
        lines.append(f"followed from {ends}: off the path by {through.off:.1e} at most")
        if through.kind == "tangent":
            law = "at path speed 1"
        else:
            law = f"under the law, in {through.times[-1] * 2:.3g} s"
        lines.append(f"joint rates {law}: {through.rate:.3g} rad/s at most")
    if through.exponent:
        lines.append(f"joint rates at constant path speed grow as |s|^{through.exponent:.3f} (measured)")
    yield Section(f"{through.robot.name}, {through.task.name}", lines=tuple(map(minus, lines)))
    if len(through.s):
        cells = tuple(
            (fixed_point(through.times[i], 3), minus(f"{through.s[i]:.3e}"),
             *joint_cells(through.robot, through.joints[i], deg=deg))
            for i in range(0, len(through.s), max(1, len(through.s) // 8))
        )  # fmt: skip
        yield Section("The motion", columns=("t [s]", "s", *joint_heads(through.robot, deg=deg)), rows=cells, texts=())
    yield Section(through.sentence)
