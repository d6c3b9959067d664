"""What is known of an arm's postures: the verdict, poses with their solutions, a path; as data and for people."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees

from rankdrop.exact.posture_changes import Decision
from rankdrop.local.block import generic_rank
from rankdrop.results.codec import Record, plain, robot_to_dict
from rankdrop.results.explanation.words import minus
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.task import Task
from rankdrop.units import heading

SCHEMA = "rankdrop/aspects/1"
CUSPIDAL, NOT_CUSPIDAL, NOT_FOUND = "cuspidal", "not cuspidal", "none found"


@dataclass(frozen=True, slots=True)
class PosturesSettings:
    """How postures were looked for.

    Attributes:
        poses, most: how many were to be solved, and at most while none decided.
        starts, seed: of Newton's method for each.
        limits: within the joint limits.
        length_scale: translation is divided by it [m].
        version: of rankdrop.
    """

    poses: int
    most: int
    starts: int
    seed: int
    limits: bool
    length_scale: float
    version: str


@dataclass(frozen=True, eq=False)
class Solved:
    """One pose: the solutions of its inverse that were found.

    Attributes:
        q: (k, n) regular solutions [rad, m]; the first is the configuration whose pose it is.
        aspect: (k,) numbers from 1; equal ones are joined by paths proven free. Solutions of different numbers are
            proven to be in different aspects where the sign differs, or the arm is proven not to be cuspidal.
        sign: (k,) of det J.
        names: (k,) the signs of the factors of det J where they tell all solutions apart ("elbow +, wrist −"), else
            the sign of det J.
        near_cusp: the pose was chosen next to a cusp, not at random.
    """

    q: Array
    aspect: tuple[int, ...]
    sign: tuple[int, ...]
    names: tuple[str, ...]
    near_cusp: bool

    @property
    def per_aspect(self) -> tuple[int, ...]:
        """Number of solutions in each aspect, most first."""
        return tuple(sorted(Counter(self.aspect).values(), reverse=True))


@dataclass(frozen=True, eq=False)
class Change:
    """A path between two solutions of one pose, or any two configurations, proven free of singularities.

    Attributes:
        q: (T, n) corners [rad, m], straight lines in joint space between them; the end is a solution up to whole turns.
        clearance: the smallest |det J| at sample points of it, J without unit.
        evaluations: enclosures that the proof took.
        own: it starts at the configuration that was asked about.
    """

    q: Array
    clearance: float
    evaluations: int
    own: bool = False


@dataclass(frozen=True, eq=False)
class Postures:
    """What was found.

    Attributes:
        robot, task, settings: what was asked.
        decision: what is known without a search.
        solved: the poses.
        change: a path from one solution of a pose to another; None where none was found or none exists.
        notes: what was rounded.
        complete: False after Ctrl-C.
    """

    robot: Robot
    task: Task
    settings: PosturesSettings
    decision: Decision
    solved: tuple[Solved, ...]
    change: Change | None
    notes: tuple[str, ...]
    complete: bool

    @property
    def verdict(self) -> str:
        """`CUSPIDAL` (with a path), `NOT_CUSPIDAL` (proven), `NOT_FOUND`."""
        if self.change is not None:
            return CUSPIDAL
        return NOT_CUSPIDAL if self.decision.impossible else NOT_FOUND

    @property
    def sentence(self) -> str:
        """The verdict and what it rests on."""
        if self.change is not None:
            corners, spent = len(self.change.q), self.change.evaluations
            return (f"It can change its posture without a singularity (cuspidal): a path of {corners} corners from one "
                    f"solution of a pose to another is proven free ({spent:,} enclosures).")  # fmt: skip
        if self.decision.impossible:
            words = f"{self.decision.words[:1].upper()}{self.decision.words[1:]}"
            return f"It cannot change its posture without a singularity (not cuspidal): proven. {words}."
        where = " within the joint limits" if self.settings.limits else ""
        poses = f"{len(self.solved)} pose{'' if len(self.solved) == 1 else 's'}"
        return f"No change of posture without a singularity was found in {poses}{where}; that is no proof of absence."

    def to_dict(self) -> Record:
        """Plain data: docs/json.md and schema/aspects.schema.json."""
        decision, change = self.decision, self.change
        return {
            **heading(SCHEMA),
            "robot": robot_to_dict(self.robot, self.task, generic_rank(self.robot, self.task)),
            "settings": plain(self.settings),
            "verdict": self.verdict,
            "sentence": self.sentence,
            "exact": {
                "kind": decision.kind, "words": decision.words, "cusps": plain(decision.cusps),
                "nodes": plain(decision.nodes),
            },
            "poses": [
                {
                    "solutions": [
                        {"q": row.tolist(), "aspect": aspect, "sign": sign, "name": name}
                        for row, aspect, sign, name in zip(one.q, one.aspect, one.sign, one.names, strict=True)
                    ],
                    "per_aspect": list(one.per_aspect),
                    "near_cusp": one.near_cusp,
                }
                for one in self.solved
            ],
            "path": None if change is None else {
                "q": change.q.tolist(), "from_q": change.own, "clearance": change.clearance,
                "evaluations": change.evaluations,
            },
            "notes": list(self.notes),
            "complete": self.complete,
        }  # fmt: skip

    def sections(self, *, deg: bool = False) -> Iterator[Section]:
        """For people: the verdict first and last."""
        yield Section(self.sentence)
        yield Section(f"{self.robot.name}, {self.task.name}", lines=tuple(self._about()))
        if len(self.solved) == 1:
            yield self._solutions(self.solved[0], deg=deg)
        elif self.solved:
            yield self._counts()
        if self.change is not None:
            yield self._way(self.change, deg=deg)
        if self.notes:
            yield Section("Notes", lines=self.notes)
        yield Section(self.sentence)

    def path_csv(self) -> str:
        """The path as a file that `rankdrop path` reads: joints by name, one corner a line [rad, m].

        Empty where there is no path.
        """
        if self.change is None:
            return ""
        head = ",".join(joint.name for joint in self.robot.variables)
        return "\n".join([head, *(",".join(repr(float(x)) for x in row) for row in self.change.q)]) + "\n"

    def _about(self) -> Iterator[str]:
        if not self.decision.impossible:  # else the verdict says it
            yield f"without a search: {self.decision.words}"
        where = "within the joint limits" if self.settings.limits else "joint limits ignored"
        yield (f"solutions of the inverse: Newton's method from {self.settings.starts:,} starts for each pose, seed "
               f"{self.settings.seed}, {where}; more may exist")  # fmt: skip

    def _solutions(self, solved: Solved, *, deg: bool) -> Section:
        order = sorted(range(len(solved.q)), key=lambda i: (solved.aspect[i], i))
        rows = tuple(
            (f"{solved.aspect[i]}{' ←' if i == 0 else ''}", solved.names[i], *self._cells(solved.q[i], deg=deg))
            for i in order
        )
        columns = ("aspect", "sign", *self._head(deg=deg))
        notes = ("← the configuration whose pose it is", *self._what_numbers_mean())
        return Section(f"{len(solved.q)} solutions in {len(solved.per_aspect)} aspects", columns=columns, rows=rows,
                       texts=(0, 1), notes=notes)  # fmt: skip

    def _counts(self) -> Section:
        met = Counter((len(one.q), one.per_aspect) for one in self.solved if not one.near_cusp)
        rows = tuple(
            (str(count), " + ".join(map(str, sizes)), str(times))
            for (count, sizes), times in sorted(met.items(), key=lambda item: (-item[1], item[0]))
        )
        return Section("Solutions by aspect", columns=("solutions", "in the aspects", "poses"), rows=rows, texts=(1,),
                       notes=self._what_numbers_mean())  # fmt: skip

    def _what_numbers_mean(self) -> tuple[str, ...]:
        if self.decision.impossible:
            return ("every solution lies in an aspect of its own: proven",)
        joined = "solutions of one aspect are joined by paths proven free"
        if all(len(set(one.sign)) == len(set(one.aspect)) for one in self.solved):
            return (f"{joined}; aspects of different signs of det J are parted by a singularity",)
        return (f"{joined}; of aspects with the same sign no path was found, which does not prove them two",)

    def _way(self, change: Change, *, deg: bool) -> Section:
        rows = tuple((str(number), *self._cells(row, deg=deg)) for number, row in enumerate(change.q, start=1))
        lines = () if change.own else ("not from the configuration first named, but between two other solutions",)
        return Section("A change of posture without a singularity", lines=lines, columns=("", *self._head(deg=deg)),
                       rows=rows, notes=(f"straight lines between; smallest |det J| of its sample points "
                                         f"{change.clearance:.3g}, lengths by the length scale",))  # fmt: skip

    def _head(self, *, deg: bool) -> tuple[str, ...]:
        return tuple(f"{one.name} [{one.unit if one.unit == 'm' or not deg else '°'}]" for one in self.robot.variables)

    def _cells(self, q: Array, *, deg: bool) -> Iterator[str]:
        for joint, value in zip(self.robot.variables, q, strict=True):
            turned = deg and joint.unit == "rad"
            shown = degrees(float(value)) if turned else float(value)
            yield minus(f"{shown:.{2 if turned else 4}f}")
