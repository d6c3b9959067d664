"""The determinant of a Jacobian in factors, or the minors that take its place, its blocks, and the closed inverse.

    as many joints as rows      det J; where J is block triangular: det J = ± det J11 det J22
    more joints than rows       the minors |$1 … $m| of every m columns: the rank drops where all of them vanish
    fewer joints than rows      the minors of every n rows

A minor of all rows of a pose, a position or an orientation is the same number in the axes of every link, and of a pose
about every reference point: a change of either multiplies J by a matrix of determinant 1. Of other rows it is that in
the axes of the task; axes turned upside down would change its sign. The closed inverse of a square Jacobian is its
adjugate over its determinant, entry by entry, both in factors.

`decouple` finds the part of the arm behind each factor of a block triangular Jacobian (`block_form`). With the
reference point in the centre of a spherical wrist joints 4, 5, 6 do not move that point (ML and JL),

    J = [[J11, 0], [J21, J22]],    det J = det J11 · det J22,

so that the arm (J11: how joints 1, 2, 3 move the centre) and the wrist (J22: how 4, 5, 6 turn the end effector) are
singular apart.

*At the centre of a spherical group* what is lost is a direction that the arm's own lines give (JL). Where J11 is
singular, yᵀJ11 = 0, the left null vector of J is (y; 0): the centre cannot translate along y, whatever the wrist does.
Where J22 is singular, yᵀJ22 = 0, and J11 is not, a motion that leaves the centre at rest leaves the arm at rest, and
cannot turn the end effector about y.

*Beside a planar triple* it is a line along which no point can move. With the rows of the plane across the parallel axes
first, J = [[P, Q], [0, R]]. Where P is singular the three axes lie in one plane; a motion that has no part out of the
plane leaves the other joints at rest, R being regular, and moves nothing along the line that crosses the three. Where R
is singular, wᵀR = 0, the left null vector of J is (0; w): a force along z with a moment across it, which is a force
along one line parallel to the axes, or a couple. Power zero for every joint means that no point of this line moves
along it.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto
from functools import cached_property
from itertools import combinations, pairwise

import numpy as np

from rankdrop.algebra.field import P, random_point, residues, value_at
from rankdrop.algebra.matrix import submatrix, with_rows
from rankdrop.algebra.polynomial import Atom, Factors, Polynomial
from rankdrop.algebra.ring import MANY, Ring
from rankdrop.algebra.work import OutOfTime, Work
from rankdrop.errors import OptionError
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.structure import (
    ORIENTATION,
    POSE,
    POSITION,
    BlockForm,
    block_form,
    structure_of,
)
from rankdrop.exact.conjunctions import values_of
from rankdrop.exact.method_reason import Parting, PartingKind
from rankdrop.exact.signs import look, merged
from rankdrop.families.name import ArmPart, FamilyName
from rankdrop.formula.value import FOLDED, Quotient, Value
from rankdrop.formula.writing import atoms_text
from rankdrop.kinematics import task_jacobian
from rankdrop.lists import flat_map
from rankdrop.local.axes import Scene
from rankdrop.local.block import sample
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import words_of
from rankdrop.task import ROWS
from rankdrop.tolerances import DEFAULT, ENTRY
from rankdrop.units import out_of_units


class LostLine(Enum):
    """The line along which, or about which, a block that loses rank one leaves no motion.

    Of a planar triple: ACROSS, in the plane across its axes, along the line that meets these axes; ALONG, the points of
    a line parallel to them do not move along it. Of a centre where axes meet, which does not move: ABOUT, no rotation
    about the perpendicular to two axes; or which does not translate: TO_MEETING, along the line to it from where two
    axes meet; PARALLEL to an axis; FROM_AXIS, along the perpendicular from an axis to it; PERPENDICULAR to two axes.
    """

    ACROSS = auto()
    ALONG = auto()
    ABOUT = auto()
    TO_MEETING = auto()
    PARALLEL = auto()
    FROM_AXIS = auto()
    PERPENDICULAR = auto()


@dataclass(frozen=True)
class Loss:
    """The motion that a block loses where its rank falls by one.

    Attributes:
        line: along which, or about which.
        joints: from 1; their axes give the line.
        others: joints; the line of `ALONG` meets their axes.
        centre: of the "wrist", the "shoulder" or another group, "".
    """

    line: LostLine
    joints: tuple[int, ...]
    others: tuple[int, ...] = ()
    centre: str = ""


def loss_beside_plane(robot: Robot, points: Array, group: tuple[int, ...], joints: tuple[int, ...]) -> Loss | None:
    """The motion lost where one block of an arm with a planar triple loses rank one; None where there is no such line.

    Args:
        robot: the arm; all joints of `group` and `joints` are revolute.
        points: (N, n) configurations at which the block loses rank one, the other none.
        group: the three joints (from 1) with parallel axes.
        joints: of the block that loses rank: the group or all others.
    """
    scene = Scene(robot, points)
    bundle = [j - 1 for j in group]
    if joints == group:
        if not scene.coplanar(bundle).all():
            return None
        return Loss(LostLine.ACROSS, group)
    others = [j - 1 for j in joints]
    if not _has_line(scene, bundle[0], others):
        return None
    met = tuple(i + 1 for i in others if not scene.parallel[bundle[0], i].any())
    return Loss(LostLine.ALONG, group, met)


def _has_line(scene: Scene, parallel: int, others: list[int]) -> bool:
    """At every sample the null vector of (z·v, x·ω, y·ω) of the other joints has a force, and is no couple."""
    z = scene.z[parallel]
    x = np.cross(z, np.eye(3)[np.abs(z).argmin(axis=1)])
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(z, x)
    v, w = scene.screws[:, :3, others] / scene.length, scene.screws[:, 3:, others]
    rows = np.stack([np.einsum("ni,nij->nj", a, b) for a, b in ((z, v), (x, w), (y, w))], axis=1)
    return bool((np.abs(np.linalg.svd(rows)[0][:, 0, -1]) > ENTRY).all())


def loss_at_centre(
    robot: Robot, points: Array, group: tuple[int, ...], joints: tuple[int, ...], part: str
) -> Loss | None:
    """The motion lost at the centre, by the first of the lines tried along which it is lost at every sample; else None.

    Args:
        robot: the arm.
        points: (N, n) configurations at which one block loses rank one.
        group: joints (from 1) whose axes meet in the centre.
        joints: of the block that loses rank: the group or all others.
        part: "wrist", "shoulder" or "": what the group is.
    """
    scene = Scene(robot, points)
    centre = scene.common_point([j - 1 for j in group])[0]
    own = [j - 1 for j in joints]
    if joints == group:
        for i, j in combinations(own, 2):
            if _lost(np.cross(scene.z[i], scene.z[j]), scene.screws[:, 3:, own]):
                return Loss(LostLine.ABOUT, (i + 1, j + 1), centre=part)
        return None
    velocity = scene.screws[:, :3, own] + np.cross(scene.screws[:, 3:, own], centre[:, :, None], axis=1)
    for line, axes, direction in _directions(scene, centre, own):
        if _lost(direction, velocity):
            return Loss(line, tuple(i + 1 for i in axes), centre=part)
    return None


def _directions(scene: Scene, centre: Array, own: list[int]) -> Iterator[tuple[LostLine, tuple[int, ...], Array]]:
    """Directions that an arm's lines give, the plainest first: the line, its axes from 0, and (N, 3)."""
    axes = [i for i in own if i in scene.axes]
    for i, j in pairwise(axes):
        if scene.meeting(i, j).all():
            meeting = scene.common_point((i, j))[0]
            yield LostLine.TO_MEETING, (i, j), centre - meeting
    for i in axes:
        yield LostLine.PARALLEL, (i,), scene.z[i]
    for i in axes:
        offset = centre - scene.p[i]
        across = offset - scene.z[i] * np.sum(offset * scene.z[i], axis=-1, keepdims=True)
        yield LostLine.FROM_AXIS, (i,), across
    for i, j in combinations(own, 2):
        yield LostLine.PERPENDICULAR, (i, j), np.cross(scene.z[i], scene.z[j])


def _lost(direction: Array, velocities: Array) -> bool:
    """Whether no column of (N, 3, k) velocities has a part along the direction (N, 3), at every sample.

    A part counts from a share `ENTRY` of the largest velocity on.
    """
    length = np.linalg.norm(direction, axis=1)
    if (length < ENTRY).any():
        return False
    part = np.einsum("ni,nij->nj", direction / length[:, None], velocities)
    return bool((np.abs(part) <= ENTRY * np.abs(velocities).max()).all())


@dataclass(frozen=True, eq=False)
class Part:
    """One factor of a block: a family of singular configurations.

    Attributes:
        called: as `analyze` names it; None where no real configurations are on it.
        block: name of the block.
        atoms: irreducible conditions; values of one joint that belong together are together.
        multiplicity: of the factor in the block's determinant.
        text: the condition.
        witness: a configuration q on it [rad, m]; None where no real one was found.
        lost: the motion lost there, seen in a frame in which it stands still or at one configuration.
        loss: the motion lost at the centre of a spherical group, or of a planar triple, by the lines of the arm;
            checked at several configurations; None where there is no such line.
    """

    called: FamilyName | None
    block: str
    atoms: tuple[Atom, ...]
    multiplicity: int
    text: str
    witness: tuple[float, ...] | None
    lost: tuple[str, ...]
    loss: Loss | None

    @property
    def statement(self) -> str:
        """The motion lost in words; "" where no line of the arm says it."""
        if self.loss is None:
            return ""
        statement: str = words_of(self.loss).loss_text(self.loss)
        return statement

    @property
    def name(self) -> str:
        """Name in words; that of the block where the part has none."""
        return str(self.called or self.block)

    @property
    def roles(self) -> tuple[ArmPart, ...]:
        """The parts of an arm that the name speaks of."""
        if self.called is None:
            return ()
        return self.called.parts


@dataclass(frozen=True, eq=False)
class Block:
    """A square diagonal block.

    Attributes:
        chain, form: the arm, and its block triangular Jacobian.
        name: "arm", "wrist", "shoulder", "in plane", …
        joints: its columns, numbered from 1.
        rows: its rows, out of vx … wz.
    """

    chain: Chain
    form: BlockForm
    name: str
    joints: tuple[int, ...]
    rows: tuple[str, ...]

    @property
    def columns(self) -> list[list[Polynomial]]:
        """One list of trigonometric polynomials per joint."""
        places = [self.chain.task.rows.index(ROWS.index(row)) for row in self.rows]
        return with_rows([self.form.columns[j - 1] for j in self.joints], places)

    @cached_property
    def determinant(self) -> Polynomial:
        """Of the block, reduced."""
        return self.chain.ring.determinant([list(row) for row in zip(*self.columns, strict=True)])

    @cached_property
    def factors(self) -> Factors:
        """Of the determinant; its letters' factors are lengths assumed not to be zero."""
        return self.chain.ring.factor(self.determinant)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """One per factor that depends on the configuration, named after real configurations on it."""
        powers = dict(self.factors.atoms)
        return tuple(self._part(atoms, powers) for atoms in merged(list(powers)))

    def _part(self, atoms: tuple[Atom, ...], powers: dict[Atom, int]) -> Part:
        chain = self.chain
        seen, points, lost = look(chain, atoms)
        return Part(
            called=seen,
            block=self.name,
            atoms=atoms,
            multiplicity=max(int(powers[atom]) for atom in atoms),
            text=atoms_text(chain.ring, atoms),
            witness=tuple(map(float, out_of_units(chain.robot, points[0]))) if len(points) else None,
            lost=lost,
            loss=self._loss(points),
        )

    def _loss(self, points: Array) -> Loss | None:
        chain, form = self.chain, self.form
        if not len(points):
            return None
        if form.kind == "point":
            return loss_at_centre(chain.own, points, form.group, self.joints, form.part)
        if form.kind == "plane" and chain.task.rows == POSE and not chain.ring.prismatic:
            return loss_beside_plane(chain.own, points, form.group, self.joints)
        return None


@dataclass(frozen=True, eq=False)
class Decoupling:
    """A Jacobian taken apart. det J = ± product of the blocks' determinants.

    Attributes:
        chain: the arm.
        form: the block triangular Jacobian, with the reason why it is that.
        blocks: the two; ML and JL's order (arm before wrist) where there is a spherical group.
    """

    chain: Chain
    form: BlockForm
    blocks: tuple[Block, ...]

    @property
    def parts(self) -> tuple[Part, ...]:
        """Of all blocks."""
        return tuple(flat_map(lambda block: block.parts, self.blocks))


def decouple(chain: Chain) -> Decoupling | None:
    """Take a square Jacobian apart into two blocks, where that is a proof.

    Args:
        chain: from `exact_chain`.

    Returns:
        None where the Jacobian is not square, has no block triangular form of the known kinds, or is singular
        everywhere; `parting_of` says which.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> found = decouple(exact_chain(open_robot("anthropomorphic")))
        >>> [(block.name, [str(part.roles[0]) for part in block.parts]) for block in found.blocks]
        [('arm', ['elbow', 'shoulder']), ('wrist', ['wrist'])]
    """
    if chain.n == chain.task.m:
        form = block_form(chain, structure_of(chain))
    else:
        form = None
    if form is None:
        return None
    halves = ((form.group, form.group_rows), (form.rest, form.rest_rows))
    blocks = tuple(
        Block(chain, form, name, joints, tuple(ROWS[r] for r in rows))
        for name, (joints, rows) in zip(form.names, halves, strict=True)
    )
    if any(block.determinant == 0 for block in blocks):
        return None
    return Decoupling(chain, form, blocks[::-1] if form.kind in ("point", "last axis") else blocks)


def parting_of(chain: Chain) -> Parting:
    """How the Jacobian parts into the blocks of `decouple`, or why that returns None."""
    structure = structure_of(chain)
    if structure.wrist:
        part = "wrist"
    elif structure.shoulder:
        part = "shoulder"
    else:
        part = ""
    parted = Parting(PartingKind.ONE_PIECE, columns=chain.n, rows=chain.task.m)
    kind = _obstacle(chain, part)
    if kind is PartingKind.ARM_NOT_SQUARE:
        return replace(parted, kind=kind, part=part)
    if kind is not None:
        return replace(parted, kind=kind)
    form = block_form(chain, structure)
    if form is None:
        return parted
    return replace(parted, kind=PartingKind(form.kind), joints=form.group, part=form.part, turns=form.turns)


def _obstacle(chain: Chain, part: str) -> PartingKind | None:
    """Why no square blocks are looked for; None where they are. `part`: a spherical part of the arm, or ""."""
    n, m = chain.n, chain.task.m
    if chain.coupled:
        return PartingKind.COUPLED
    if n > m:
        if chain.task.rows == POSE and part:
            return PartingKind.ARM_NOT_SQUARE
        return PartingKind.NOT_SQUARE
    if n < m:
        return PartingKind.TOO_FEW_JOINTS
    if chain.ring.determinant([list(row) for row in zip(*chain.columns, strict=True)]) == 0:
        return PartingKind.ALWAYS_SINGULAR
    return None


_TRIED = 20  # random configurations at most on which a sign is read off
MOST = 60
"""More minors than that are counted, not written."""


class MinorOf(Enum):
    """The rows and columns of a Jacobian that a minor takes.

    BLOCK: a square matrix. SCREWS, COLUMNS: all rows, and as many joint screws or columns. ROWS: all columns.
    """

    BLOCK = auto()
    SCREWS = auto()
    COLUMNS = auto()
    ROWS = auto()


@dataclass(frozen=True, eq=False)
class Minor:
    """The determinant of some rows and columns of a Jacobian.

    Attributes:
        of: the rows and columns that are taken.
        joints: of its columns, numbered from 1, in order.
        rows: of the task, out of vx … wz, in order.
        value: the determinant.
        shifts: θ = q + shift, per joint: code is in the joint variables q [rad].
        matrix: of a block: "J", "J11" or "J22".
        block: name of the block of "J11" and "J22", as `Block.name`; "" of all others.
    """

    of: MinorOf
    joints: tuple[int, ...]
    rows: tuple[str, ...]
    value: Value
    shifts: tuple[float, ...]
    matrix: str = "J"
    block: str = ""

    @property
    def about(self) -> str:
        """Rows and joints of a block in words; "" of all others, of which `Determinants.meaning` gives them."""
        about: str = words_of(self).about_minor(self)
        return about

    @property
    def name(self) -> str:
        """In formulas: "det J11", "|$1 $2 $3 $4 $5 $6|" of screws, "|J1 J3|" of columns, "|vx wz|" of rows."""
        return minor_name(self.of, self.joints, self.rows, self.matrix)

    @property
    def entries(self) -> tuple[tuple[str, str], ...]:
        """(letter, index) of each of its columns or rows: ("$", "1"), ("J", "1") or ("v", "x"); none of a block."""
        return _entries(self.of, self.joints, self.rows)

    @property
    def mark(self) -> str:
        """A name for code: det_J11, minor_1_2_3, minor_vx_wz."""
        if self.of is MinorOf.BLOCK:
            return f"det_{self.matrix}"
        if self.of is MinorOf.ROWS:
            taken = self.rows
        else:
            taken = tuple(map(str, self.joints))
        return f"minor_{'_'.join(taken)}"

    @property
    def factored(self) -> bool:
        """Whether its factors were found."""
        return self.value.factors is not None or self.value.polynomial == 0


def minor_name(of: MinorOf, joints: Sequence[int], rows: Sequence[str], matrix: str = "J") -> str:
    """The name of a minor in formulas: see `Minor`."""
    if of is MinorOf.BLOCK:
        return f"det {matrix}"
    words = [letter + index for letter, index in _entries(of, joints, rows)]
    return f"|{' '.join(words)}|"


def _entries(of: MinorOf, joints: Sequence[int], rows: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """See `Minor.entries`."""
    if of is MinorOf.BLOCK:
        return ()
    if of is MinorOf.ROWS:
        return tuple((row[0], row[1:]) for row in rows)
    letter = {MinorOf.SCREWS: "$", MinorOf.COLUMNS: "J"}[of]
    return tuple((letter, str(joint)) for joint in joints)


@dataclass(frozen=True)
class MinorsLeft:
    """Minors that were not computed within the limit on work.

    Attributes:
        of: the rows and columns of the only one; None where several more were not tried.
        joints: of its columns, numbered from 1, in order.
        rows: of the task, out of vx … wz, in order.
        number: of minors.
    """

    of: MinorOf | None = None
    joints: tuple[int, ...] = ()
    rows: tuple[str, ...] = ()
    number: int = 1

    def __str__(self) -> str:
        """In words: "|J1 J3|", or "3 more minors"."""
        words: str = words_of(self).minors_left_words(self)
        return words


class RowAxes(Enum):
    """The axes in which the rows of minors are taken.

    EVERY_LINK: any, a minor is the same number in the axes of every link. TASK: those of the task. LINK: the frame of
    one link, where all six rows are there. SHORT: axes in which the rows are short.
    """

    EVERY_LINK = auto()
    TASK = auto()
    LINK = auto()
    SHORT = auto()


@dataclass(frozen=True, eq=False)
class Determinants:
    """The determinant of an arm, or the minors that all vanish where it is singular.

    Attributes:
        of: the rows and columns that each minor takes; of BLOCK there is one determinant, and two of blocks with it
            where `form` is given.
        rows: of the task, out of vx … wz, in order.
        joints: number of the arm's joint variables.
        axes: in which the rows are taken.
        link: number of the link in the frame of which they are where `axes` is LINK; else 0.
        form: the block triangular Jacobian, with its reference point; None where there is none.
        sign: det J = sign · det J11 det J22, where `form` is given.
        minors: the determinant or the minors, those that vanish everywhere too; of blocks first, det J last.
        left: minors that were not computed within the limit on work.
    """

    of: MinorOf
    rows: tuple[str, ...]
    joints: int
    axes: RowAxes
    minors: tuple[Minor, ...]
    left: tuple[MinorsLeft, ...] = ()
    link: int = 0
    form: BlockForm | None = None
    sign: int = 1

    @property
    def product(self) -> str:
        """The determinant as product of those of its blocks: "det J = −det J11 det J22"; "" where it has none."""
        if self.form is None:
            return ""
        if self.sign < 0:
            return "det J = −det J11 det J22"
        return "det J = det J11 det J22"

    @property
    def meaning(self) -> str:
        """The minors and where the rank drops, in a sentence."""
        meaning: str = words_of(self).meaning_of_minors(self)
        return meaning

    def lines(self, most: int | None = FOLDED) -> tuple[str, ...]:
        """In text.

        Args:
            most: factors of more characters are told by their size; None for none.
        """
        told: tuple[str, ...] = words_of(self).lines(self, most)
        return told

    def folded(self) -> bool:
        """Whether `lines` tells a factor by its size."""
        return self.lines() != self.lines(None)


def determinants_of(chain: Chain, work: Work) -> Determinants:
    """The determinant or the minors of an arm, in factors.

    Args:
        chain: from `exact_chain`.
        work: limit; what is not done by then is told.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> found = determinants_of(exact_chain(open_robot("anthropomorphic")), Work())
        >>> found.product
        'det J = det J11 det J22'
        >>> [f"{minor.name} = {minor.value.text()}" for minor in found.minors]
        ['det J11 = −a2 d4 s3 (a2 c2 + d4 c23)', 'det J22 = −s5', 'det J = a2 d4 s3 s5 (a2 c2 + d4 c23)']
    """
    split = decouple(chain)
    if split is not None:
        return _decoupled(chain, split)
    minors: list[Minor] = []
    left: list[MinorsLeft] = []
    shifts = tuple(map(float, chain.whole_shifts))
    chosen = list(maximal_minors(chain))
    for of, joints, rows in chosen[:MOST]:
        words = tuple(ROWS[r] for r in rows)
        place = [chain.task.rows.index(r) for r in rows]
        try:
            work.check()
            found = chain.ring.determinant(submatrix(chain.columns, (j - 1 for j in joints), place))
            if len(rows) == chain.task.m:
                found = found * _sign(chain, found, joints)
            else:
                found = found
            value = _value(chain.ring, found, work)
        except OutOfTime:
            left.append(MinorsLeft(of, joints, words))
            continue
        minors.append(Minor(of, joints, words, value, shifts))
    if len(chosen) > MOST:
        left.append(MinorsLeft(number=len(chosen) - MOST))
    axes = _axes(chain)
    link = chain.frame if axes is RowAxes.LINK else 0
    return Determinants(chosen[0][0], _row_names(chain), chain.n, axes, tuple(minors), tuple(left), link)


def _value(ring: Ring, p: Polynomial, work: Work) -> Value:
    # a longer one takes minutes and gigabytes to factor
    work.check()
    return Value(ring, p, None if p == 0 or len(p) > MANY else ring.factors_within(p, work.left))


def _sign(chain: Chain, p: Polynomial, joints: tuple[int, ...]) -> int:
    """1, or −1 where a minor of all rows has the other sign in the axes of the task, see at a configuration."""
    if p == 0 or chain.task.rows in (POSE, POSITION, ORIENTATION):
        return 1
    for q in sample(chain.own, chain.own_task, _TRIED, 0):
        wanted = np.linalg.det(task_jacobian(chain.own, q, chain.own_task)[:, [j - 1 for j in joints]])
        value = values_of(chain, p, np.atleast_2d(q) + chain.shifts)[0][0]
        if abs(wanted) > DEFAULT.singular:
            return 1 if wanted * value > 0 else -1
    return 1


MinorChoice = tuple[MinorOf, tuple[int, ...], tuple[int, ...]]
"""The kind of a minor, its joints, numbered from 1, and its rows, numbers 0 … 5 of (v; ω)."""


def maximal_minors(chain: Chain) -> Iterator[MinorChoice]:
    """The determinant of a square Jacobian, else its minors of the highest order; in the order of `combinations`."""
    joints, rows = tuple(range(1, chain.n + 1)), chain.task.rows
    if chain.n == len(rows):
        yield MinorOf.BLOCK, joints, rows
    elif chain.n > len(rows):
        if len(rows) == 6 and not chain.coupled:
            of = MinorOf.SCREWS
        else:
            of = MinorOf.COLUMNS
        for some in combinations(joints, len(rows)):
            yield of, some, rows
    else:
        for kept in combinations(rows, chain.n):
            yield MinorOf.ROWS, joints, kept


def _axes(chain: Chain) -> RowAxes:
    """The axes in which the rows of the minors are."""
    rows = chain.task.rows
    if chain.n < len(rows):
        if rows == POSE:
            return RowAxes.LINK
        return RowAxes.SHORT
    if rows in (POSE, POSITION, ORIENTATION):
        return RowAxes.EVERY_LINK
    return RowAxes.TASK


def _row_names(chain: Chain) -> tuple[str, ...]:
    """Rows of the task, out of vx … wz."""
    return tuple(ROWS[row] for row in chain.task.rows)


def _decoupled(chain: Chain, split: Decoupling) -> Determinants:
    """det J11 and det J22 of the blocks, and det J with the sign of their product."""
    ring, rows, shifts = chain.ring, _row_names(chain), tuple(map(float, chain.whole_shifts))
    minors = []
    for matrix, block in zip(("J11", "J22"), split.blocks, strict=True):
        value = Value(ring, block.determinant, block.factors)
        minors.append(Minor(MinorOf.BLOCK, block.joints, block.rows, value, shifts, matrix, block.name))
    whole = ring.determinant(submatrix(split.form.columns, range(chain.n), range(len(rows))))
    joints = tuple(range(1, chain.n + 1))
    whole = whole * _sign(chain, whole, joints)
    value = Value(ring, whole, ring.factor(whole))
    minors.append(Minor(MinorOf.BLOCK, joints, rows, value, shifts))
    together = ring.reduce(split.blocks[0].determinant * split.blocks[1].determinant)
    if whole == together:
        sign = 1
    else:
        sign = -1
    return Determinants(MinorOf.BLOCK, rows, chain.n, _axes(chain), tuple(minors), form=split.form, sign=sign)


POINTS = 3
"""Random points at which the product with the Jacobian is computed modulo the prime."""


@dataclass(frozen=True, eq=False)
class ClosedInverse:
    """The inverse of a square matrix over the trigonometric ring.

    Attributes:
        determinant: in factors where they were found.
        entries: entries[i][j] of the inverse.
        agree, tested: at how many of the random points modulo the prime J · adj J = det J · 1.
    """

    determinant: Value
    entries: tuple[tuple[Quotient, ...], ...]
    agree: int
    tested: int


def closed_inverse(ring: Ring, rows: Sequence[Sequence[Polynomial]], work: Work) -> ClosedInverse:
    """J⁻¹ = adj J / det J.

    Args:
        ring: of the entries.
        rows: square.
        work: limit.

    Raises:
        OptionError: not square, or the determinant vanishes everywhere.
        OutOfTime: the limit was met.
    """
    n = len(rows)
    if any(len(row) != n for row in rows):
        raise OptionError(
            "only a square Jacobian has an inverse", got=f"{n} rows, {len(rows[0])} joints",
            mend="a task with as many rows as joints",
        )
    work.check()
    whole = ring.determinant(rows)
    if whole == 0:
        raise OptionError("a Jacobian that is singular everywhere has no inverse", mend="a task that the arm can serve")
    below = _value(ring, whole, work)
    adjugate = [[_cofactor(ring, rows, j, i, work) for j in range(n)] for i in range(n)]
    entries = tuple(tuple(Quotient(_value(ring, x, work), below) for x in row) for row in adjugate)
    agree = sum(_agrees(ring, rows, adjugate, whole, seed) for seed in range(POINTS))
    return ClosedInverse(below, entries, agree, POINTS)


def _cofactor(ring: Ring, rows: Sequence[Sequence[Polynomial]], i: int, j: int, work: Work) -> Polynomial:
    work.check()
    minor = ring.determinant([[x for b, x in enumerate(row) if b != j] for a, row in enumerate(rows) if a != i])
    return -minor if (i + j) % 2 else minor


def _agrees(
    ring: Ring,
    rows: Sequence[Sequence[Polynomial]],
    adjugate: Sequence[Sequence[Polynomial]],
    whole: Polynomial,
    seed: int,
) -> bool:
    """Whether J · adj J = det J · 1 at a random point modulo the prime."""
    n, point = len(rows), random_point(ring, random.Random(seed))
    (one, _), (two, _) = (residues(ring, matrix, [point])[0] for matrix in (rows, adjugate))
    middle = value_at(ring, whole, point)
    entries = ((i, j, sum(one[i][k] * two[k][j] for k in range(n)) % P) for i in range(n) for j in range(n))
    return all(value == (middle if i == j else 0) for i, j, value in entries)
