"""The part of the arm behind each factor of a block triangular Jacobian, and what is lost where it is singular.

With the reference point in the centre of a spherical wrist joints 4, 5, 6 do not move that point (ML and JL),

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

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum, auto
from functools import cached_property
from itertools import combinations, pairwise

import numpy as np

from rankdrop.algebra.matrix import with_rows
from rankdrop.algebra.polynomial import Atom, Factors, Polynomial
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.structure import (
    POSE,
    BlockForm,
    block_form,
    structure_of,
)
from rankdrop.exact.method_reason import Parting, PartingKind
from rankdrop.exact.signs import look, pair_angles
from rankdrop.families.name import ArmPart, FamilyName
from rankdrop.formula.writing import atoms_text
from rankdrop.lists import flat_map
from rankdrop.local.axes import Scene
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import words_of
from rankdrop.task import ROWS
from rankdrop.tolerances import ENTRY
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
class BlockLoss:
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


def loss_beside_plane(robot: Robot, points: Array, group: tuple[int, ...], joints: tuple[int, ...]) -> BlockLoss | None:
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
        return BlockLoss(LostLine.ACROSS, group)
    others = [j - 1 for j in joints]
    if not _has_line(scene, bundle[0], others):
        return None
    met = tuple(i + 1 for i in others if not scene.parallel[bundle[0], i].any())
    return BlockLoss(LostLine.ALONG, group, met)


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
) -> BlockLoss | None:
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
                return BlockLoss(LostLine.ABOUT, (i + 1, j + 1), centre=part)
        return None
    velocity = scene.screws[:, :3, own] + np.cross(scene.screws[:, 3:, own], centre[:, :, None], axis=1)
    for line, axes, direction in _directions(scene, centre, own):
        if _lost(direction, velocity):
            return BlockLoss(line, tuple(i + 1 for i in axes), centre=part)
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
class BlockFactor:
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
    loss: BlockLoss | None

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
class DiagonalBlock:
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
    def parts(self) -> tuple[BlockFactor, ...]:
        """One per factor that depends on the configuration, named after real configurations on it."""
        powers = dict(self.factors.atoms)
        return tuple(self._part(atoms, powers) for atoms in pair_angles(list(powers)))

    def _part(self, atoms: tuple[Atom, ...], powers: dict[Atom, int]) -> BlockFactor:
        chain = self.chain
        seen, points, lost = look(chain, atoms)
        return BlockFactor(
            called=seen,
            block=self.name,
            atoms=atoms,
            multiplicity=max(int(powers[atom]) for atom in atoms),
            text=atoms_text(chain.ring, atoms),
            witness=tuple(map(float, out_of_units(chain.robot, points[0]))) if len(points) else None,
            lost=lost,
            loss=self._loss(points),
        )

    def _loss(self, points: Array) -> BlockLoss | None:
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
    blocks: tuple[DiagonalBlock, ...]

    @property
    def parts(self) -> tuple[BlockFactor, ...]:
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
        DiagonalBlock(chain, form, name, joints, tuple(ROWS[r] for r in rows))
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
    if chain.has_mimics:
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
