"""Decoupling: a block triangular Jacobian, its determinant as a product, and the part of the arm behind each factor.

ML and JL: with the reference point in the centre of a spherical wrist joints 4, 5, 6 do not move that point,

    J = [[J11, 0], [J21, J22]],    det J = det J11 · det J22,

so that the arm (J11: how joints 1, 2, 3 move the centre) and the wrist (J22: how 4, 5, 6 turn the end effector) are
singular apart. The same is done for spherical shoulders and for joints that move in planes (`block_form`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rankdrop.exact.algebra.atom import Atom, Factors
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.structure import ExactStructure, listed, structure_of
from rankdrop.exact.decoupling.across import across_statement
from rankdrop.exact.decoupling.block_form import POSE, BlockForm, block_form
from rankdrop.exact.decoupling.centre import centre_statement
from rankdrop.exact.decoupling.parts import UNSEEN, condition_text, look, merged
from rankdrop.robot.model import Array
from rankdrop.task import ROWS
from rankdrop.units import out_of_units


@dataclass(frozen=True, eq=False)
class Part:
    """One factor of a block: a family of singular configurations.

    Attributes:
        name: as `analyze` names it ("elbow: …"); that of the block where no real configurations are on it.
        roles: out of "shoulder", "elbow", "wrist", as the geometry says.
        block: name of the block.
        atoms: irreducible conditions; values of one joint that belong together are together.
        multiplicity: of the factor in the block's determinant.
        text: the condition.
        witness: a configuration q on it [rad, m]; None where no real one was found.
        lost: the motion lost there, seen in a frame in which it stands still or at one configuration.
        statement: the motion lost at the centre of a spherical group, or beside a planar triple, by the lines of the
            arm; checked at several configurations; "" where there is none in words.
    """

    name: str
    roles: tuple[str, ...]
    block: str
    atoms: tuple[Atom, ...]
    multiplicity: int
    text: str
    witness: tuple[float, ...] | None
    lost: tuple[str, ...]
    statement: str


@dataclass(frozen=True, eq=False)
class Block:
    """A square diagonal block.

    Attributes:
        name: "arm", "wrist", "shoulder", "in plane", …
        joints: its columns, numbered from 1.
        rows: its rows, out of vx … wz.
        columns: one list of trigonometric polynomials per joint.
        determinant: of the block, reduced.
        factors: of the determinant; its letters' factors are lengths assumed not to be zero.
        parts: one per factor that depends on the configuration.
    """

    name: str
    joints: tuple[int, ...]
    rows: tuple[str, ...]
    columns: tuple[tuple[Polynomial, ...], ...]
    determinant: Polynomial
    factors: Factors
    parts: tuple[Part, ...]


@dataclass(frozen=True, eq=False)
class Decoupling:
    """A Jacobian taken apart. det J = ± product of the blocks' determinants.

    Attributes:
        chain: the arm.
        structure: what was recognised.
        kind: "point", "slides", "plane", "plane and slide" or "last axis".
        reason: why the Jacobian is block triangular.
        point, axes: where and in which axes it is.
        columns: all n columns there, one entry per row of the task.
        blocks: the two; ML and JL's order (arm before wrist) where there is a spherical group.
    """

    chain: Chain
    structure: ExactStructure
    kind: str
    reason: str
    point: str
    axes: str
    columns: tuple[tuple[Polynomial, ...], ...]
    blocks: tuple[Block, ...]

    @property
    def parts(self) -> tuple[Part, ...]:
        """Of all blocks."""
        return tuple(part for block in self.blocks for part in block.parts)

    def to_dict(self) -> dict[str, Any]:
        """For a result file: polynomials as text, matrices by rows."""
        return {
            "kind": self.kind,
            "reason": self.reason,
            "point": self.point,
            "axes": self.axes,
            "structure": list(self.structure.sentences()),
            "blocks": [
                {
                    "name": block.name,
                    "joints": list(block.joints),
                    "rows": list(block.rows),
                    "matrix": [[str(x) for x in row] for row in zip(*block.columns, strict=True)],
                    "determinant": str(block.determinant),
                    "nonzero_lengths": [str(letter) for letter, _ in block.factors.letters],
                    "parts": [_part_dict(part) for part in block.parts],
                }
                for block in self.blocks
            ],
        }

    def sentences(self) -> tuple[str, ...]:
        """Reason, point, blocks and parts in words."""
        found = [f"{self.reason}.", f"Reference point: {self.point}. Axes: {self.axes}."]
        for block in self.blocks:
            found.append(f"{block.name}: rows {', '.join(block.rows)} of joints {listed(block.joints)}.")
            if not block.parts:
                found.append("  never singular")
            for part in block.parts:
                lost = part.statement or "; ".join(part.lost)
                found.append(f"  {part.text}: {part.name}" + (f": {lost}" if lost else ""))
        return tuple(found)


def decouple(chain: Chain, *, names: bool = True) -> Decoupling | None:
    """Take a square Jacobian apart into two blocks, where that is a proof.

    Args:
        chain: from `exact_chain`.
        names: look at real configurations of each part to name it and to say what is lost there.

    Returns:
        None where the Jacobian is not square, has no block triangular form of the known kinds, or is singular
        everywhere; `why_not` says which.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> found = decouple(exact_chain(open_robot("anthropomorphic")))
        >>> [(block.name, [part.roles[0] for part in block.parts]) for block in found.blocks]
        [('arm', ['elbow', 'shoulder']), ('wrist', ['wrist'])]
    """
    if chain.n != chain.task.m:
        return None
    structure = structure_of(chain)
    form = block_form(chain, structure)
    if form is None:
        return None
    halves = [(form.group, form.group_rows, form.names[0]), (form.rest, form.rest_rows, form.names[1])]
    blocks = [_block(chain, form, joints, rows, name, names) for joints, rows, name in halves]
    if any(block is None for block in blocks):
        return None
    found = tuple(block for block in blocks if block is not None)
    return Decoupling(
        chain=chain,
        structure=structure,
        kind=form.kind,
        reason=form.reason,
        point=form.point,
        axes=form.axes,
        columns=tuple(tuple(column) for column in form.columns),
        blocks=found[::-1] if form.kind in ("point", "last axis") else found,
    )


def why_not(chain: Chain) -> str:
    """Why `decouple` returns None for an arm, in words; "" where it does not."""
    n, m = chain.n, chain.task.m
    structure = structure_of(chain)
    near = "".join(f"; near-structural: {one.text}" for one in structure.near)
    if n > m:
        return _wide(chain, structure) + near
    if n < m:
        return f"{n} joints never reach the {m} freedoms of the task: the Jacobian has more rows than columns"
    form = block_form(chain, structure)
    if _always_singular(chain):
        return "the arm is singular at every configuration"
    if form is not None:
        return ""
    groups = "no three axes meet in one point, are parallel or slide: " if chain.task.rows == POSE else ""
    return f"{groups}the Jacobian stays in one piece{near}"


def _part_dict(part: Part) -> dict[str, Any]:
    return {
        "name": part.name,
        "roles": list(part.roles),
        "condition": part.text,
        "multiplicity": part.multiplicity,
        "witness": None if part.witness is None else list(part.witness),
        "lost": list(part.lost),
        "statement": part.statement,
    }


def _block(
    chain: Chain, form: BlockForm, joints: tuple[int, ...], rows: tuple[int, ...], name: str, names: bool
) -> Block | None:
    """One diagonal block, factored; None where its determinant is zero."""
    place = [chain.task.rows.index(r) for r in rows]
    matrix = [[form.columns[j - 1][i] for j in joints] for i in place]
    determinant = chain.ring.determinant(matrix)
    if determinant == 0:
        return None
    factors = chain.ring.factor(determinant)
    times = dict(factors.atoms)
    parts = tuple(_part(chain, form, joints, name, group, times, names) for group in merged(list(times)))
    return Block(
        name=name,
        joints=joints,
        rows=tuple(ROWS[r] for r in rows),
        columns=tuple(tuple(column) for column in zip(*matrix, strict=True)),
        determinant=determinant,
        factors=factors,
        parts=parts,
    )


def _part(
    chain: Chain,
    form: BlockForm,
    joints: tuple[int, ...],
    block: str,
    atoms: tuple[Atom, ...],
    times: dict[Atom, Any],
    names: bool,
) -> Part:
    seen = look(chain, atoms) if names else UNSEEN
    return Part(
        name=seen.name or block,
        roles=seen.roles,
        block=block,
        atoms=atoms,
        multiplicity=max(int(times[atom]) for atom in atoms),
        text=condition_text(chain.ring, atoms),
        witness=tuple(float(x) for x in out_of_units(chain.robot, seen.points[0])) if len(seen.points) else None,
        lost=seen.lost,
        statement=_statement(chain, form, joints, seen.points) if len(seen.points) else "",
    )


def _statement(chain: Chain, form: BlockForm, joints: tuple[int, ...], points: Array) -> str:
    """What is lost, by the lines of the arm."""
    if form.kind == "point":
        return centre_statement(chain.own, points, form.group, joints, form.names[0])
    if form.kind == "plane" and chain.task.rows == POSE and not chain.ring.prismatic:
        return across_statement(chain.own, points, form.group, joints)
    return ""


def _always_singular(chain: Chain) -> bool:
    rows = [list(row) for row in zip(*chain.columns, strict=True)]
    return bool(chain.ring.determinant(rows) == 0)


def _wide(chain: Chain, structure: ExactStructure) -> str:
    """Of a redundant arm: the blocks are not both square."""
    n, m = chain.n, chain.task.m
    part = "wrist" if structure.wrist else "shoulder" if structure.shoulder else ""
    if chain.task.rows != POSE or not part:
        return f"{n} joints for {m} freedoms: the Jacobian is not square, so that it has no two square blocks"
    return (
        f"{n} joints for {m} freedoms: with a spherical {part} the Jacobian is block triangular, but the arm's block "
        f"is 3 × {n - 3}: where the {part} alone loses a freedom, null motions of the arm may make up for it"
    )
