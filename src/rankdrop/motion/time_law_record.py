"""A tool path at a singular configuration: what is known of it, as data and for people."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees

import numpy as np

from rankdrop.local.block import generic_rank
from rankdrop.results.codec import Record, robot_to_dict
from rankdrop.results.explanation.words import minus
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.task import ROWS, Task
from rankdrop.units import heading
from rankdrop.version import VERSION

SCHEMA = "rankdrop/through/1"
HIGHEST = 6
"""Order that is looked for."""
REGULAR, PASSES, TANGENT, TURNS, CORNER, NOT, UNDECIDED = (
    "regular", "passes", "tangent", "turns back", "corner", "not trackable", "undecided",
)  # fmt: skip
TRACKABLE = (REGULAR, PASSES, TANGENT, CORNER)


@dataclass(frozen=True, eq=False)
class Through:
    """What is known of a tool path at one configuration.

    Attributes:
        robot, task, q: where.
        along: (m,) dx/ds of the path in the rows of the task, in the base's axes [m, rad].
        bend: (m,) d²x/ds².
        kind: `PASSES` (through, standing still for an instant), `TANGENT` (through, at any speed), `CORNER` (through,
            with a stop at which the joints change direction), `TURNS` (only on one side; the arm comes back in another
            posture), `NOT`, `UNDECIDED`, `REGULAR` (not singular).
        order: k of s = c t^k; 1 where any smooth time law will do; None where there is none.
        outside: u·ξ/|ξ|: share of the path's direction that is lost [1].
        side: of s on which the path is tracked where it turns back: +1 or −1; else 0.
        times: (T,) [s] and
        s: (T,) the law that keeps the joint rates finite,
        joints: (T, n) and the configurations [rad, m] that were followed; empty where there are none.
        off: largest deviation of the tool from the path on the way, lengths by the length scale [1].
        rate: largest joint rate under that law [rad/s; slides scaled].
        exponent: measured power of |s| by which joint rates per path speed grow near the singularity; 0 where they do
            not; expected is −(k − 1)/k.
    """

    robot: Robot
    task: Task
    q: Array
    along: Array
    bend: Array
    kind: str
    order: int | None
    outside: float
    side: int
    times: Array
    s: Array
    joints: Array
    off: float
    rate: float
    exponent: float

    @property
    def trackable(self) -> bool:
        """Whether the path leads through, from one side of the configuration to the other."""
        return self.kind in TRACKABLE

    @property
    def sentence(self) -> str:
        """In words."""
        k = self.order
        if self.kind == PASSES:
            return (f"Trackable through the singularity with s = c t^{k}: the path stands still there for an instant; "
                    f"at constant speed joint rates grow as |s|^(−{(k or 1) - 1}/{k}).")  # fmt: skip
        side = "ahead of it" if self.side > 0 else "before it"
        return {
            REGULAR: "Not singular: trackable with any smooth time law.",
            TANGENT: "Trackable through the singularity at any speed: the path is in the image of J to second order.",
            CORNER: f"Trackable through the singularity with a stop at it, where the joints change direction: s = ± c "
            f"t^{2 * (k or 1)}.",
            TURNS: f"Not trackable through: the path is within reach only {side}. With s = c t^{k} the arm reaches the "
            "singularity and comes back on the path in another posture, at finite joint rates.",
            NOT: "Not trackable: no joint motion from this configuration follows the path, on either side of it.",
            UNDECIDED: f"Undecided: nothing is settled by terms up to order {HIGHEST}.",
        }[self.kind]

    def to_dict(self) -> Record:
        """Plain data: docs/json.md."""
        return {
            **heading(SCHEMA),
            "robot": robot_to_dict(self.robot, self.task, generic_rank(self.robot, self.task)),
            "version": VERSION,
            "q": self.q.tolist(), "along": self.along.tolist(), "bend": self.bend.tolist(),
            "kind": self.kind, "sentence": self.sentence, "trackable": self.trackable, "order": self.order,
            "side": self.side, "outside": self.outside,
            "motion": {"times": self.times.tolist(), "s": self.s.tolist(), "q": self.joints.tolist()},
            "off": self.off, "rate": self.rate, "exponent": self.exponent,
        }  # fmt: skip

    def sections(self, *, deg: bool = False) -> Iterator[Section]:
        """For people: the verdict first and last."""
        yield Section(self.sentence)
        rows = ", ".join(f"{ROWS[row]} {value:g}" for row, value in zip(self.task.rows, self.along, strict=True))
        lines = [f"path along {rows} [m, rad], {100 * abs(self.outside):.3g} % of it lost to first order"]
        if len(self.s):
            ends = f"s = {self.s[0]:.4g} to {self.s[-1]:.4g}"
            lines.append(f"followed from {ends}: off the path by {self.off:.1e} at most")
            law = "at path speed 1" if self.kind == TANGENT else f"under the law, in {self.times[-1] * 2:.3g} s"
            lines.append(f"joint rates {law}: {self.rate:.3g} rad/s at most")
        if self.exponent:
            lines.append(f"joint rates at constant path speed grow as |s|^{self.exponent:.3f} (measured)")
        yield Section(f"{self.robot.name}, {self.task.name}", lines=tuple(minus(x) for x in lines))
        if len(self.s):
            yield self._table(deg=deg)
        yield Section(self.sentence)

    def path_csv(self) -> str:
        """The motion with its times as a file that `rankdrop path` reads [s; rad, m]; empty where there is none."""
        if not len(self.s):
            return ""
        head = ",".join(["time", *(joint.name for joint in self.robot.variables)])
        rows = np.column_stack([self.times - self.times[0], self.joints])
        return "\n".join([head, *(",".join(repr(float(x)) for x in row) for row in rows)]) + "\n"

    def _table(self, *, deg: bool) -> Section:
        turned = [deg and joint.unit == "rad" for joint in self.robot.variables]
        some = range(0, len(self.s), max(1, len(self.s) // 8))
        rows = []
        for i in some:
            shown = zip(self.joints[i], turned, strict=True)
            cells = (f"{degrees(x):.2f}" if angle else f"{x:.4f}" for x, angle in shown)
            rows.append((f"{self.times[i]:.3f}", f"{self.s[i]:.3e}", *cells))
        names = zip(self.robot.variables, turned, strict=True)
        head = ("t [s]", "s", *(f"{joint.name} [{'°' if angle else joint.unit}]" for joint, angle in names))
        return Section("The motion", columns=head, rows=tuple(tuple(minus(x) for x in row) for row in rows),
                       texts=())  # fmt: skip
