"""GR: Gallardo-Alvarado and Rico-Martínez, An Application of the Lie Product to the Higher Singular Configurations
Problem of Serial Manipulators. The RCRRRR example, its procedures, and what finite motion says of its conclusion.
"""

from __future__ import annotations

from functools import cache
from math import sqrt

import numpy as np

from papers.item import Sheet, Shown, listed, rounded
from rankdrop.local import (
    PRINTED_IN_GR,
    OrderedReport,
    OrderedScrewSet,
    lie_product,
    motion,
    relations_at,
    report,
    session,
    systems_at,
)
from rankdrop.robot import Array, JointKind, open_robot

R = 1 / sqrt(2)
SCREWS = np.array([
    [1, 0, 0, 0, 0, -1], [0, 0, 0, 0, 1, 0], [0, 1, 0, 0, 0, 0], [0, 1, 0, 0, 0, 5], [1, 0, 0, 0, 0, 0],
    [0, R, R, 0, -10 * R, 10 * R], [0, R, -R, 0, 10 * R, 10 * R],
])  # fmt: skip
"""(s; s_O) of screws 1 to 7 as printed in section 5."""
COLUMN_7 = np.array([0, -R, R, 0, 10 * R, 10 * R])
"""The last column of the printed J."""
READ = """1. 0. 0. 0. 0. -1  0. 0. 0. 0. 1. 0  0. 1. 0. 0. 0. 0  0. 1. 0. 0. 0. 5  1. 0. 0. 0. 0. 0
0. .707106 .707106 0. -7.07106 7.07106  0. .707106 -.707106 0. 7.07106 7.07106"""
PRODUCTS = "12 yes, 13 no, 14 no, 15 yes, 23 yes, 24 yes, 25 yes, 34 no, 35 no, 45 no"
DT = 1e-4


@cache
def example() -> OrderedScrewSet:
    """The screws of the catalogue's arm at q = 0."""
    return OrderedScrewSet.of(open_robot("rcrrrr"), np.zeros(7))


@cache
def searched() -> OrderedReport:
    """GR's search on it, and the judgement by finite motion."""
    return report(example())


def screws(sheet: Sheet) -> None:
    """Sections 2.1 and 2.3: screws, velocity state, the Lie product."""
    rng = np.random.default_rng(0)
    s, r, h = rng.normal(size=3), rng.normal(size=3), 0.3
    s /= np.linalg.norm(s)
    moment = h * s + np.cross(s, r)  # r from a point of the axis to O
    turned = motion(np.concatenate([s, moment]), 0.4)
    point = -r  # a point of the axis, seen from O; it slides along the axis by h · 0.4
    back = turned[:3, :3] @ point + _shift(turned)
    sheet.identity("section 2.1", "moment part: the motion of the screw slides its axis along itself",
                   "s_O = h s + s × r", float(np.abs(back - point - h * 0.4 * s).max()))  # fmt: skip
    A, B = example().screws[3], example().screws[5]
    sheet.identity("eq. 2", "Lie product by this package", "[S1 S2] = (s1 × s2; s1 × s_O2 − s2 × s_O1)",
                   float(np.abs(example().lie(4, 6) - np.concatenate([
                       np.cross(A[:3], B[:3]), np.cross(A[:3], B[3:]) - np.cross(B[:3], A[3:])])).max()))  # fmt: skip
    sheet.identity("section 2.3", "anticommutative; zero with itself", "[S1 S2] = −[S2 S1], [S S] = 0",
                   float(max(np.abs(lie_product(A, B) + lie_product(B, A)).max(), np.abs(lie_product(A, A)).max())))
    derivative = (motion(A, 1e-6) @ B - motion(A, -1e-6) @ B) / 2e-6
    sheet.identity("eq. 3", "derivative of the motion of S1 acting on S2, by central differences",
                   "d/dt {m1(t) S2 m1(t)⁻¹} at t = 0", float(np.abs(derivative - lie_product(A, B)).max()),
                   tolerance=1e-7)  # fmt: skip
    product = lie_product(A, B)
    sheet.identity("section 2.3", "direction of [S1 S2]", "orthogonal to the plane of the directions of S1 and S2",
                   float(max(abs(product[:3] @ A[:3]), abs(product[:3] @ B[:3]))))  # fmt: skip


def _shift(adjoint: Array) -> Array:
    """(3,) translation of a motion from its matrix [[R, 0], [p̂ R, R]]."""
    skew = adjoint[3:, :3] @ adjoint[:3, :3].T
    return np.array([skew[2, 1], skew[0, 2], skew[1, 0]])


def rules(sheet: Sheet) -> None:
    """Section 3: what the screws at the ends can do, groups, the five rules."""
    found, here = searched(), example()
    gains = {joint.number: joint.gain for joint in found.joints}
    sheet.claim("section 3, item 1", "screws 1 and 7 can escape", "can never produce an escape",
                f"rank gained by their finite motion: {gains[1]}, {gains[7]}", gains[1] == gains[7] == 0)  # fmt: skip
    sheet.claim("section 3, item 2", "screws of the spherical group {5, 6, 7} can escape", "cannot effect an escape",
                f"rank gained by finite motion: {gains[5]}, {gains[6]}, {gains[7]}",
                gains[5] == gains[6] == gains[7] == 0)  # fmt: skip
    errors = [np.abs(here.moved(4, t).screws - here.screws - t * (here.propagated(4).screws - here.screws)).max()
              for t in (DT, DT / 10)]  # fmt: skip
    sheet.claim("section 3, rule 1", "S_k + [S_j S_k] Δt against the finite motion", "≈, for small Δt",
                f"a tenth of Δt makes the error {errors[0] / errors[1]:.0f} times smaller",
                bool(abs(errors[0] / errors[1] - 100) < 2))  # fmt: skip
    outside = [(u, v) for u, v, inside in here.subspace(1, 5).entries if not inside]
    sheet.claim("section 3, rule 2", "Lie products of the run 1 … 5 that leave its span", "there are such",
                ", ".join(f"[{u} {v}]" for u, v in outside), bool(outside))  # fmt: skip
    sheet.claim("section 3, rule 3", "dimension of the run after the substitution", "its cardinality, 5",
                f"{here.newscrews(3, 5).dimension(1, 5)} by screw 3, {here.newscrews(4, 5).dimension(1, 5)} by screw 4",
                here.newscrews(3, 5).dimension(1, 5) == here.newscrews(4, 5).dimension(1, 5) == 5)  # fmt: skip
    first = found.joints[0]
    sheet.claim(
        "section 3, rule 4", "a Lie product outside the span contains the screw to actuate",
        "[S_u S_v] outside the span contains the screw responsible",
        f"[1 3] is {'outside' if (1, 3) in outside else 'inside'}, and screw 1 {'can' if first.escapes else 'cannot'} "
        "escape",
        (1, 3) not in outside or first.escapes,
        reason="Σ λ_i [S_1 S_i] over the dependency Σ λ_i S_i = 0 is what counts, and it vanishes.",
        shown=Shown(f"|Σ λ_i [S_1 S_i]| = {rounded(first.weighted)}, rank gained by finite motion {first.gain}.",
                    (1, 3) in outside and first.weighted < 1e-9 and first.gain == 0),
    )  # fmt: skip
    carried = {(a, b): d for a, b, d in found.joints[3].dimensions}
    sheet.claim("section 3, rule 5", "one actuator restores several runs", "more than one minimal singular subset",
                f"screw 4, carried to the end of the chain: 1–5 to {carried[1, 5]}, 1–6 to {carried[1, 6]}, 2–7 to "
                f"{carried[2, 7]}", carried[1, 5] == 5 and carried[2, 7] == 6)  # fmt: skip


def definitions(sheet: Sheet) -> None:
    """Sections 2.2 and 4.3: minimal singular ordered subsets."""
    loose = [run for run in example().subsets() if run.msos and not run.minimal]
    names = ", ".join(f"{run.first}–{run.last}" for run in loose)
    minimal = ", ".join(f"{run.first}–{run.last}" for run in example().subsets() if run.minimal)
    sheet.claim(
        "section 2.2", "cardinality − dimension = 1 means minimal", "minimal singular ordered subset",
        f"only {minimal} contain no shorter dependent run", not loose,
        reason="The test does not look inside the run.",
        shown=Shown(f"Runs {names} pass it and contain 1–5 or 3–7.", len(loose) == 2),
    )  # fmt: skip
    inside = {joint for run in example().subsets() if run.minimal for joint in range(run.first, run.last + 1)}
    sheet.claim("section 2.2", "where the screws that escape are", "in at least one minimal singular ordered subset",
                f"screws {', '.join(map(str, searched().escapes))} are in 1–5 and 3–7",
                set(searched().escapes) <= inside)  # fmt: skip
    run = example().msos(1, 7)
    sheet.claim(
        "section 4.3", "msos refuses runs of more than six screws", "if 6 < j − i then refuse",
        f"msos(1, 7) is let through with 7 screws, since 7 − 1 = 6; its loss is {run.loss}", run.last - run.first > 6,
        reason="j − i is one less than the number of screws: the test should be 5 < j − i.",
        shown=Shown("", run.last - run.first + 1 > 6 and not run.last - run.first > 6),
    )  # fmt: skip


def matrices(sheet: Sheet) -> None:
    """Section 5: the screws, the Jacobian, its rank."""
    here = example().screws
    sheet.identity("section 5", "screws 1 to 7: the arm of the catalogue", "the seven printed screws",
                   float(np.abs(here - SCREWS).max()), tolerance=1e-12)  # fmt: skip
    kinds = [joint.kind for joint in open_robot("rcrrrr").variables]
    sheet.claim("section 5", "kinds of joints", "R C R R R R, with $2, $3 the cylindrical pair",
                " ".join("P" if kind is JointKind.PRISMATIC else "R" for kind in kinds),
                kinds[1] is JointKind.PRISMATIC and kinds.count(JointKind.REVOLUTE) == 6)  # fmt: skip
    sheet.identity("section 5", "columns 1 to 6 of J", "the screws", float(np.abs(here[:6] - SCREWS[:6]).max()),
                   tolerance=1e-12)  # fmt: skip
    error = float(np.abs(here[6] - COLUMN_7).max())
    both = here.copy()
    both[6] = COLUMN_7
    sheet.identity(
        "section 5", "column 7 of J", "0, −1/√2, 1/√2, 0, 10/√2, 10/√2", error, ours=listed(here[6]),
        tolerance=1e-12, reason="Its direction is negated against $7, its moment is not.",
        shown=Shown(f"It differs from $7 by {rounded(error)}, and is a screw of another line.",
                    error > 1.0 and np.linalg.matrix_rank(np.stack([here[6], COLUMN_7])) == 2),
    )  # fmt: skip
    J = here.T
    sheet.identity("section 2.2, section 5", "determinant of J Jᵀ", "|J Jᵀ| = 0", float(abs(np.linalg.det(J @ J.T))))
    sheet.numbers("section 5", "dim [$1 … $7]", "5", searched().dimension)
    sheet.claim(
        "section 5", "freedoms lost", "apparently, the manipulator has lost two degrees of freedom",
        f"{searched().dependencies} dependencies among 7 screws, but {searched().lost} task freedom lost (6 − 5)",
        searched().lost == 2, reason="7 − 5 counts dependencies; one of them is the arm's redundancy.",
        shown=Shown(f"Generic rank {searched().generic}, rank here {searched().dimension}.",
                    searched().generic == 6 and searched().dimension == 5),
    )  # fmt: skip
    sheet.numbers("section 6", "freedoms lost, as the conclusions have it", "1", searched().lost)
    meet = {relation.words for relation in relations_at(open_robot("rcrrrr"), np.zeros(7))}
    sheet.claim("section 5", "screws 5, 6, 7", "concurrent, a spheric pair",
                "; ".join(sorted(words for words in meet if "5, 6, 7" in words)),
                "axes 5, 6, 7 meet in one point" in meet)  # fmt: skip
    groups = {(system.numbers, system.kind, system.dimension) for system in systems_at(open_robot("rcrrrr"),
        np.zeros(7))}
    sheet.claim("section 5", "the group that {5, 6, 7} generates", "SO(3), a subalgebra of e(3)",
                ", ".join(f"{kind}, dimension {size}" for numbers, kind, size in groups if numbers == (5, 6, 7)),
                ((5, 6, 7), "spherical", 3) in groups)  # fmt: skip


def printed_session(sheet: Sheet) -> None:
    """Section 5: the session as printed, instruction by instruction."""
    here = example()
    sheet.numbers("section 5", "readoss(1,7)", READ.replace("\n", "  "), here.readoss(1, 7),
                  layout="seven rows: " + READ,
                  reason="GR's six digits of 1/√2 are cut off, not rounded.")  # fmt: skip
    run = here.msos(1, 5)
    sheet.same("section 5", "msos(1,5)", "dimension 4, lost of freedom 1, it is a msos",
               f"dimension {run.dimension}, lost of freedom {run.loss}, it is {'' if run.msos else 'not '}a msos")
    found = here.subspace(1, 5)
    entries = ", ".join(f"{u}{v} {'yes' if inside else 'no'}" for u, v, inside in found.entries)
    sheet.same("section 5", "subspace(1,5): is [S_u S_v] inside the span", PRODUCTS, entries)
    sheet.same("section 5", "screws that can restore (1, 5)", "3, 4", ", ".join(map(str, found.actuators)))
    four, three = here.newscrews(4, 5), here.newscrews(3, 5)
    sheet.numbers("section 5", "newscrews(4,5): S5", "1. 0. -1. 0. 5. 0", four.readoss(5, 5))
    sheet.numbers("section 5", "dimension(1,5), dimension(1,6) after it", "5 5", [four.dimension(1, 5),
                  four.dimension(1, 6)])
    sheet.numbers("section 5", "readoss(4,5)", "0 1. 0 0 0 5. 1. 0 0 0 0 0", here.readoss(4, 5))
    sheet.numbers("section 5", "newscrews(3,5): S4, S5", "0 1. 0. 5. 0. 5.  1. 0. -1. 0. 0. 0", three.readoss(4, 5))
    sheet.numbers("section 5", "dimension(1,5), dimension(1,6), dimension(2,7) after it", "5 6 6",
                  [three.dimension(1, 5), three.dimension(1, 6), three.dimension(2, 7)])  # fmt: skip
    steps = session(here)
    told = [f"{instruction} {lines[0]}" for instruction, lines in steps if instruction.startswith("dimension")]
    sheet.same("section 4", "the session as a whole, instruction by instruction: what `dimension` prints",
               "dimension(1, 5) 5, dimension(1, 6) 5, dimension(1, 5) 5, dimension(1, 6) 6, dimension(2, 7) 6",
               ", ".join(told), reason=f"All {len(PRINTED_IN_GR)} instructions of section 5 in their order, each on "
               "what the one before left (rankdrop escape --lie).")  # fmt: skip


def conclusion(sheet: Sheet) -> None:
    """Which joint escapes."""
    found, here = searched(), example()
    rates = {joint.number: joint.rate for joint in found.joints}
    dims = {j: [here.propagated(j).dimension(*run) for run in ((1, 5), (1, 6), (2, 7), (1, 7))] for j in (3, 4)}
    sheet.same("section 5", "what the printed procedure concludes", "3", ", ".join(map(str, found.printed)))
    sheet.claim(
        "section 5", "joints that lead out of the singularity", "only the third, $3; $4 cannot restore 1–6",
        f"joints {', '.join(map(str, found.escapes))}; σ6 grows by {rounded(rates[3])} per rad for joint 3, by "
        f"{rounded(rates[4])} for joint 4", found.escapes == (3,),
        reason="newscrews(4, 5) leaves screws 6 and 7 where they were; a joint carries every later screw.",
        shown=Shown(
            f"Carried to the end, dimensions of 1–5, 1–6, 2–7, 1–7 are {dims[3]} for joint 3 and {dims[4]} for joint "
            "4; finite motion agrees.",
            found.escapes == (3, 4) and dims[3] == [5, 6, 5, 6] and dims[4] == [5, 6, 6,
            6] and rates[4] > 2 * rates[3]),
    )  # fmt: skip
    kinds = [joint.kind for joint in open_robot("rcrrrr").variables][:3]
    turns = kinds.count(JointKind.REVOLUTE)
    sheet.claim(
        "section 5", "$3 is the third revolute", "the third revolute, $3", f"$3 is revolute number {turns}", turns == 3,
        reason="$2 is the slide of the cylindrical pair.", shown=Shown("", kinds[1] is JointKind.PRISMATIC),
    )  # fmt: skip
    sheet.claim("abstract, section 6", "one revolute is enough to recover full mobility", "actuating only one revolute",
                f"joints that reach rank 6 alone by finite motion: {', '.join(map(str, found.escapes))}",
                3 in found.escapes)  # fmt: skip


SECTIONS = (
    ("screws", screws), ("definitions", definitions), ("matrices", matrices), ("session", printed_session),
    ("rules", rules), ("conclusion", conclusion),
)  # fmt: skip
