"""Determinants of ML and JL as exact products, block triangular forms, and the motion lost at each part."""

from __future__ import annotations

from math import prod

import numpy as np
import pytest
from reference.trig import value

from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.decoupling import decouple, parting_of
from rankdrop.exact.method_reason import PartingKind
from rankdrop.exact.remark import near_structure
from rankdrop.kinematics import jacobian, link_poses, task_jacobian
from rankdrop.robot.dh import from_dh
from rankdrop.robot.ideal import ideal
from rankdrop.robot.open import open_robot
from rankdrop.task import ROWS, Frame
from rankdrop.text.by_hand import steps_of
from rankdrop.text.structure import parting_text
from rankdrop.tolerances import DEFAULT

HALF = np.pi / 2
PUMA = {"a2": 0.4318, "a3": 0.0203, "d3": 0.15005, "d4": 0.4318001}  # d4 ≠ a2, else both would get one letter
CRAIG_ALPHA = (0, "-pi/2", 0, "-pi/2", "pi/2", "-pi/2")


def craig(sign: int = 1) -> Chain:
    """PUMA 560 by Craig's modified table; `sign` −1: all twists the other way."""
    twists = [0 if t == 0 else (t if sign > 0 else t.replace("-", "") if "-" in t else f"-{t}") for t in CRAIG_ALPHA]
    a, d = (0, 0, PUMA["a2"], PUMA["a3"], 0, 0), (0, 0, PUMA["d3"], PUMA["d4"], 0, 0)
    rows = [(a[i], twists[i], d[i], 0) for i in range(6)]
    return exact_chain(from_dh(rows, convention="modified"), lengths=PUMA)


def textbook() -> Chain:
    """PUMA 560 by the standard table α = 90, 0, −90, 90, −90, 0."""
    rows = [
        (0, "pi/2", 0, 0), (PUMA["a2"], 0, 0, 0), (PUMA["a3"], "-pi/2", PUMA["d3"], 0),
        (0, "pi/2", PUMA["d4"], 0), (0, "-pi/2", 0, 0), (0, 0, 0, 0),
    ]  # fmt: skip
    return exact_chain(from_dh(rows, convention="standard"), lengths=PUMA)


def full_determinant(chain):
    return chain.ring.determinant([list(row) for row in zip(*chain.columns, strict=True)])


def sums(ring, *joints):
    """(sine, cosine) of a sum of joint angles."""
    s, c = ring.zero, ring.one
    for j in joints:
        s, c = s * ring.c[j] + c * ring.s[j], c * ring.c[j] - s * ring.s[j]
    return s, c


def is_plus_minus(ring, p, q):
    return ring.reduce(p - q) == 0 or ring.reduce(p + q) == 0


def arm(rows, kinds=None):
    return exact_chain(from_dh(rows, convention="standard", kinds=kinds))


WRIST = [(0, "pi/2", 0.3, 0), (0, "-pi/2", 0, 0), (0, 0, 0.1, 0)]
BUILT = {
    "spherical shoulder": (
        arm([(0, "pi/2", 0, 0), (0, "-pi/2", 0, 0), (0.1, "pi/2", 0.4, 0),
             (0.5, 0, 0.07, 0), (0.2, "pi/2", 0.11, 0), (0, 0, 0, 0)]),
        "point", (1, 2, 3),
    ),
    "spherical group amid": (
        arm([(0.1, "pi/2", 0, 0), (0.2, "pi/2", 0.3, 0), (0, "pi/2", 0.5, 0),
             (0, "-pi/2", 0, 0), (0.3, "pi/2", 0.2, 0), (0.1, 0, 0, 0)]),
        "point", (3, 4, 5),
    ),
    "gantry with offset wrist": (
        arm([(0, "pi/2", 0, "pi/2"), (0, "pi/2", 0, "pi/2"), (0, 0, 0, 0),
             (0.1, "pi/2", 0, 0), (0.2, "pi/2", 0.1, 0), (0, 0, 0, 0)], "PPPRRR"),
        "slides", (1, 2, 3),
    ),
    "planar triple first": (
        arm([(0.5, 0, 0, 0), (0.4, 0, 0, 0), (0.1, "pi/2", 0.2, 0),
             (0.2, "pi/2", 0.15, 0), (0.1, "pi/2", 0.05, 0), (0, 0, 0, 0)]),
        "plane", (1, 2, 3),
    ),
    "planar triple last": (
        arm([(0.1, "pi/2", 0, 0), (0.2, "pi/2", 0.3, 0), (0.3, "pi/2", 0.1, 0),
             (0.5, 0, 0, 0), (0.4, 0, 0, 0), (0, 0, 0, 0)]),
        "plane", (4, 5, 6),
    ),
    "plane with a slide": (
        arm([(0.2, "pi/2", 0, 0), (0, "pi/2", 0.1, 0), (0, "-pi/2", 0, 0),
             (0.3, "pi/2", 0.1, 0), (0.2, "pi/2", 0.15, 0), (0, 0, 0, 0)], "RRPRRR"),
        "plane", (2, 3, 4),
    ),
    "turns about one direction": (
        arm([(0.5, 0, 0, 0), (0.4, "pi/4", 0, 0), (0, "pi/2", 0, 0),
             (0.1, "pi/2", 0.2, 0), (0.2, "pi/3", 0.1, 0), (0, 0, 0, 0)], "RRPPRR"),
        "plane and slide", (1, 2, 3, 4),
    ),
    "skew twists": (
        arm([(0.1, "0.7", 0.2, 0), (0.3, "1.1", 0.1, 0), (0.2, "0.4", 0.3, 0),
             (0, "0.9", 0.3, 0), (0, "-0.6", 0, 0), (0, 0, 0.1, 0)]),
        "point", (4, 5, 6),
    ),
}  # fmt: skip
CATALOGUE = ("anthropomorphic", "puma560", "stanford", "ur5", "ur10e", "irb140", "z1", "vx300s", "scara", "planar3r")


DEAD = {
    "axes 1, 2 on one line": arm(
        [(0, 0, 0, 0), (0.3, 0, 0, 0), (0.1, "pi/2", 0, 0), (0, "pi/2", 0.2, 0), (0, "pi/2", 0, 0), (0, 0, 0, 0)]
    ),
    "four axes through a point": arm(
        [(0.1, "pi/2", 0, 0), (0.3, "pi/2", 0.2, 0), (0, "pi/2", 0.4, 0), (0, "pi/2", 0, 0), (0, "pi/2", 0, 0),
         (0, 0, 0, 0)]
    ),
    "four parallel axes": arm(
        [(0.1, 0, 0, 0), (0.3, 0, 0.2, 0), (0.2, 0, 0.4, 0), (0.2, "pi/2", 0, 0), (0.1, "pi/2", 0, 0), (0, 0, 0, 0)]
    ),
}  # fmt: skip


def chains():
    yield from ((name, exact_chain(open_robot(name))) for name in CATALOGUE)
    yield from ((name, chain) for name, (chain, _, _) in BUILT.items())
    yield from (("textbook", textbook()), ("craig", craig()), ("craig, other signs", craig(-1)))


CHAINS = dict(chains())


@pytest.mark.parametrize("name", CHAINS)
def test_product_of_blocks_is_the_full_determinant(name):
    chain = CHAINS[name]
    found = decouple(chain)
    assert found is not None
    product = chain.ring.one
    for block in found.blocks:
        product = chain.ring.reduce(product * block.determinant)
    assert product != 0
    assert is_plus_minus(chain.ring, product, full_determinant(chain))


@pytest.mark.parametrize("name", CHAINS)
def test_product_of_blocks_is_the_numeric_determinant(name, rng):
    chain = CHAINS[name]
    found = decouple(chain)
    for q in rng.uniform(-np.pi, np.pi, (3, chain.n)):
        rows = jacobian(chain.robot, q)[list(chain.task.rows)]
        product = prod(value(chain, block.determinant, q) for block in found.blocks)
        assert abs(product) == pytest.approx(abs(np.linalg.det(rows)), rel=1e-8, abs=1e-11)


@pytest.mark.parametrize("name", CHAINS)
def test_matrix_is_block_triangular_and_of_the_same_rank(name, rng):
    chain = CHAINS[name]
    found = decouple(chain)
    rows = [ROWS[r] for r in chain.task.rows]
    first, second = found.blocks if found.form.kind not in ("point", "last axis") else found.blocks[::-1]
    for j in first.joints:
        for row in second.rows:
            assert found.form.columns[j - 1][rows.index(row)] == 0
    assert sorted(first.joints + second.joints) == list(range(1, chain.n + 1))
    q = rng.uniform(-np.pi, np.pi, chain.n)
    numeric = np.array([[value(chain, x, q) for x in column] for column in found.form.columns]).T
    expected = jacobian(chain.robot, q)[list(chain.task.rows)]
    assert abs(np.linalg.det(numeric)) == pytest.approx(abs(np.linalg.det(expected)))


@pytest.mark.parametrize("name", BUILT)
def test_built_arms_decouple_as_built(name):
    chain, kind, group = BUILT[name]
    found = decouple(chain)
    assert found.form.kind == kind
    assert group in [block.joints for block in found.blocks]


def test_anthropomorphic_determinant_of_ml_and_jl():
    chain = CHAINS["anthropomorphic"]
    ring = chain.ring
    a2, a3 = ring.letter["a2"], ring.letter["d4"]
    arm_block, wrist = decouple(chain).blocks
    _, c23 = sums(ring, 2, 3)
    assert is_plus_minus(ring, arm_block.determinant, a2 * a3 * ring.s[3] * (a2 * ring.c[2] + a3 * c23))
    assert is_plus_minus(ring, wrist.determinant, ring.s[5])
    assert [part.roles for part in arm_block.parts] == [("elbow",), ("shoulder",)]
    assert [part.roles for part in wrist.parts] == [("wrist",)]
    assert arm_block.parts[0].text == "θ3 = 0 or π"


def test_third_column_of_jl_uses_the_third_axis(rng):
    # JL's erratum: z2 × (p3 − p2), printed with p1
    chain = CHAINS["anthropomorphic"]
    arm_block = decouple(chain).blocks[0]
    q = rng.uniform(-np.pi, np.pi, 6)
    numeric = np.array([[value(chain, x, q) for x in column] for column in arm_block.columns]).T
    screws = jacobian(chain.robot, q, Frame(0, 0))
    centre = np.linalg.lstsq(
        np.concatenate([_cross(screws[3:, j]) for j in (3, 4, 5)]),
        np.concatenate([screws[:3, j] for j in (3, 4, 5)]),
        rcond=None,
    )[0]
    columns = np.stack([screws[:3, j] + np.cross(screws[3:, j], centre) for j in range(3)], axis=1)
    assert numeric.T @ numeric == pytest.approx(columns.T @ columns)  # the same up to the axes
    point_2 = np.cross(screws[3:, 1], screws[:3, 1])
    as_printed = columns.copy()
    as_printed[:, 2] = np.cross(screws[3:, 2], centre - point_2)
    assert abs(np.linalg.det(as_printed)) != pytest.approx(abs(np.linalg.det(columns)), abs=1e-6)


def _cross(w):
    """ω with v + ω × C = 0 as [ω]ᵀ C = v."""
    return -np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


@pytest.mark.parametrize(
    ("chain", "elbow_sign", "shoulder_sign"),
    [(textbook(), 1, 1), (craig(), 1, 1), (craig(-1), -1, -1), (CHAINS["puma560"], 1, 1)],
    ids=["textbook", "craig", "craig, other signs", "catalogue"],
)
def test_puma_determinant(chain, elbow_sign, shoulder_sign):
    # a2 s5 (d4 c3 + a3 s3)(a2 c2 + a3 c23 − d4 s23), up to the direction of axes 2 and 4
    ring = chain.ring
    a2, a3, d4 = (ring.letter[x] for x in ("a2", "a3", "d4"))
    s23, c23 = sums(ring, 2, 3)
    elbow = d4 * ring.c[3] + elbow_sign * a3 * ring.s[3]
    shoulder = a2 * ring.c[2] + a3 * c23 - shoulder_sign * d4 * s23
    assert is_plus_minus(ring, full_determinant(chain), a2 * ring.s[5] * elbow * shoulder)
    found = decouple(chain)
    assert [part.roles for part in found.parts] == [("elbow",), ("shoulder",), ("wrist",)]
    assert all(part.multiplicity == 1 for part in found.parts)


def test_puma_is_singular_on_the_shoulder_in_spite_of_its_offset():
    # ML's "not possible with an offset" is false for the rank
    chain = CHAINS["puma560"]
    shoulder = next(part for part in decouple(chain).parts if part.roles == ("shoulder",))
    assert float(chain.letters["d3"]) > 0.1
    sigma = np.linalg.svd(task_jacobian(chain.robot, np.array(shoulder.witness), chain.task), compute_uv=False)
    assert sigma[-1] < DEFAULT.singular < sigma[-2]


def test_stanford_determinant():
    chain = CHAINS["stanford"]
    ring = chain.ring
    assert is_plus_minus(ring, full_determinant(chain), ring.q[3] ** 2 * ring.s[2] * ring.s[5])
    assert {part.text: part.multiplicity for part in decouple(chain).parts} == {
        "θ2 = 0 or π": 1, "q3 = 0": 2, "θ5 = 0 or π": 1,
    }  # fmt: skip


def test_ur5_determinant():
    chain = CHAINS["ur5"]
    ring = chain.ring
    a2, a3, d5 = (ring.letter[x] for x in ("a2", "a3", "d5"))
    _, c23 = sums(ring, 2, 3)
    s234, _ = sums(ring, 2, 3, 4)
    shoulder = a2 * ring.c[2] + a3 * c23 + d5 * s234
    assert is_plus_minus(ring, full_determinant(chain), a2 * a3 * ring.s[3] * ring.s[5] * shoulder)
    found = decouple(chain)
    assert parting_text(parting_of(chain)).startswith("planar triple: axes 2, 3, 4 are parallel")
    assert is_plus_minus(ring, found.blocks[0].determinant, a2 * a3 * ring.s[3])
    assert is_plus_minus(ring, found.blocks[1].determinant, ring.s[5] * shoulder)
    assert [part.roles for part in found.parts] == [("elbow",), ("wrist",), ("shoulder",)]


@pytest.mark.parametrize(("name", "joint"), [("scara", 2), ("planar3r", 2)])
def test_scara_and_planar_arm(name, joint):
    chain = CHAINS[name]
    ring = chain.ring
    lengths = ring.letter["a1"] * ring.letter["a2"]
    assert is_plus_minus(ring, full_determinant(chain), lengths * ring.s[joint])
    assert [part.text for part in decouple(chain).parts] == ["θ2 = 0 or π"]


def test_lengths_assumed_nonzero_are_kept_apart():
    arm_block = decouple(CHAINS["anthropomorphic"]).blocks[0]
    assert {str(letter) for letter, _ in arm_block.factors.letters} == {"a2", "d4"}


@pytest.mark.parametrize("name", ["anthropomorphic", "puma560", "irb140", "stanford"])
def test_stated_translation_of_the_centre_is_lost(name):
    chain = exact_chain(open_robot(name))
    found = decouple(chain)
    statements = {}
    for part in found.parts:
        q = np.array(part.witness)
        # frame 4 of a standard table stands in the wrist centre where a4 = 0 and d5 = 0
        lost = np.linalg.svd(jacobian(chain.robot, q, Frame(0, 4)))[0][:, -1]
        centre = _origin(chain, q, 4)
        statements[part.roles or part.text] = part.statement
        if part in found.blocks[0].parts:
            assert np.abs(lost[3:]).max() < 1e-9
            stated = _stated(chain, part.statement, q, centre)
            assert abs(lost[:3] @ stated) == pytest.approx(1.0, abs=1e-9)
        else:
            axes = jacobian(chain.robot, q)[3:]
            stated = np.cross(axes[:, 3], axes[:, 4])
            assert part.statement.endswith("about the perpendicular to axes 4 and 5")
            assert abs(lost[3:] @ stated) / np.linalg.norm(lost[3:]) / np.linalg.norm(stated) == pytest.approx(1.0)
    assert len(statements) == 3
    assert all(statements.values())


def _origin(chain, q, link):
    """(3,) the origin of a link frame in the base."""
    return link_poses(chain.robot, q)[link, :3, 3]


def _stated(chain, statement, q, centre):
    """The unit direction that a statement names."""
    screws = jacobian(chain.robot, q, Frame(0, 0))
    axis, point = screws[3:, 1], np.cross(screws[3:, 1], screws[:3, 1])
    if statement == "the wrist centre cannot translate parallel to axis 2":
        direction = axis
    elif statement.startswith("the wrist centre cannot translate along the line from the shoulder"):
        one = screws[3:, 0], np.cross(screws[3:, 0], screws[:3, 0])
        s = np.linalg.lstsq(np.stack([one[0], -axis], axis=1), point - one[1], rcond=None)[0]
        direction = centre - (one[1] + s[0] * one[0])
    else:
        assert statement == "the wrist centre cannot translate along the perpendicular from axis 2 to it"
        direction = centre - point - axis * ((centre - point) @ axis)
    return direction / np.linalg.norm(direction)


def test_elbow_and_shoulder_of_jl_lose_what_jl_says():
    words = {part.roles[0]: part.statement for part in decouple(CHAINS["anthropomorphic"]).parts}
    assert words["elbow"].startswith("the wrist centre cannot translate along the line from the shoulder")
    assert words["shoulder"] == "the wrist centre cannot translate parallel to axis 2"
    assert words["wrist"] == (
        "with the wrist centre at rest the end effector cannot rotate about the perpendicular to axes 4 and 5"
    )


def test_an_arm_that_decouples_says_by_which_joints():
    found = parting_of(CHAINS["puma560"])
    assert (found.kind, found.joints, found.part, found.parts_exactly) == (PartingKind.POINT, (4, 5, 6), "wrist", True)


def test_an_arm_in_one_piece_and_one_always_singular():
    assert parting_of(exact_chain(open_robot("xarm6"))).kind is PartingKind.ONE_PIECE
    for name, dead in DEAD.items():
        assert decouple(dead) is None, name
        assert parting_of(dead).kind is PartingKind.ALWAYS_SINGULAR, name


def test_position_task_of_three_axes_parts_elbow_and_shoulder():
    rows = [(0, "pi/2", 0, 0), (0.5, 0, 0, 0), (0.4, 0, 0, 0)]
    chain = exact_chain(from_dh(rows, convention="standard", task="position"))
    found = decouple(chain)
    assert [(block.joints, [part.roles for part in block.parts]) for block in found.blocks] == [
        ((2, 3), [("elbow",)]),
        ((1,), [("shoulder",)]),
    ]
    assert is_plus_minus(chain.ring, found.blocks[0].determinant * found.blocks[1].determinant, full_determinant(chain))


@pytest.mark.parametrize("twist", [0, "pi/2"])
def test_scara_on_a_column(twist, rng):
    # slide first; tilted, its turns are about another direction than the task's rows
    rows = [(0, 0, 0, 0), (0.3, 0, 0, 0), (0.2, 0, 0, 0), (0, 0, 0, 0)]
    base = np.eye(4)
    if twist:
        base[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    chain = exact_chain(from_dh(rows, convention="standard", kinds="PRRR", task="scara", base=base))
    found = decouple(chain)
    if twist:
        assert found is None
        return
    assert [(block.joints, block.rows) for block in found.blocks] == [((2, 3, 4), ("vx", "vy", "wz")), ((1,), ("vz",))]
    q = rng.uniform(-3, 3, 4)
    expected = np.linalg.det(jacobian(chain.robot, q)[list(chain.task.rows)])
    assert abs(value(chain, found.blocks[0].determinant, q)) == pytest.approx(abs(expected))


def test_blocks_of_a_puma_have_their_conditions_and_lengths():
    found = decouple(CHAINS["puma560"])
    assert found.blocks[1].parts[0].text == "θ5 = 0 or π"
    assert [str(letter) for letter, _ in found.blocks[0].factors.letters] == ["a2"]


def test_a_wrist_that_is_nearly_spherical_decouples_once_it_is_ideal():
    rows = [(0, "pi/2", 0, 0), (0.5, 0, 0, 0), (0, "pi/2", 0, 0), (0, "-pi/2", 0.4, 0), (0.001, "pi/2", 0, 0),
            (0, 0, 0, 0)]  # fmt: skip
    robot = from_dh(rows, convention="standard")
    assert decouple(exact_chain(robot)) is None
    assert "the axes of joints 4, 5, 6 miss a common point by 1 mm" in map(str, near_structure(exact_chain(robot)))
    found = decouple(exact_chain(ideal(robot, length=0.002)[0]))
    assert [block.name for block in found.blocks] == ["arm", "wrist"]
    wrist = found.blocks[1].parts[0]
    assert (wrist.text, wrist.name, wrist.roles) == ("θ5 = 0 or π", "wrist: axes 4 and 6 aligned", ("wrist",))


def test_sentences_tell_reason_point_parts():
    text = "\n".join(steps_of(CHAINS["puma560"], decouple(CHAINS["puma560"]))[1].lines)
    assert "spherical wrist: axes 4, 5, 6 meet in one point" in text
    assert "wrist centre" in text
    assert "θ5 = 0 or π: wrist: axes 4 and 6 aligned" in text
