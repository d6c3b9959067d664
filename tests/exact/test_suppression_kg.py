"""KG's whole example, Canadarm2 with the letters a, c, d, entry by entry and sign by sign."""

from itertools import combinations

import pytest

pytest.importorskip("flint")

from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.suppression import suppress
from rankdrop.robot.open import open_robot
from rankdrop.text.by_hand import steps_of

SWAPPED = -1  # a determinant with rows (v; ω), as here, against KG's (ω; v): three rows pass three others
LENGTHS = {"a": 0.635, "c": 0.504, "d": 6.85}  # typical lengths of Canadarm2 [m]


class Letters:
    """KG's abbreviations: s("345") = sin(θ3 + θ4 + θ5)."""

    def __init__(self, ring):
        self.ring = ring
        self.a, self.c_, self.d = (ring.letter[x] for x in "acd")

    def both(self, joints):
        s, c = self.ring.zero, self.ring.one
        for j in map(int, joints):
            s, c = s * self.ring.c[j] + c * self.ring.s[j], c * self.ring.c[j] - s * self.ring.s[j]
        return s, c

    def s(self, joints):
        return self.both(str(joints))[0]

    def c(self, joints):
        return self.both(str(joints))[1]


@pytest.fixture(scope="module")
def found():
    chain = exact_chain(open_robot("canadarm2"), lengths=LENGTHS)
    return suppress(chain, frame=5, basic=range(2, 8))


@pytest.fixture(scope="module")
def kg(found):
    return Letters(found.chain.ring)


def equal(ring, one, two):
    return ring.reduce(one - two) == 0


def determinant(found, joints, rows=range(6)):
    """Rows are numbered as KG has them, (ω; v)."""
    columns = [[*found.columns[j - 1][3:], *found.columns[j - 1][:3]] for j in joints]
    return found.chain.ring.determinant([[column[r] for column in columns] for r in rows])


def test_the_screw_matrix_in_frame_5_is_equations_5_and_6(found, kg):
    s, c, a, length, d = kg.s, kg.c, kg.a, kg.c_, kg.d
    zero, one = kg.ring.zero, kg.ring.one
    columns = {
        1: [
            s(2) * c(345),
            -s(2) * s(345),
            c(2),
            (d * s(45) + a * c(345) + d * s(5)) * c(2) - 2 * length * s(2) * s(345),
            -(-d * c(45) + a * s(345) - d * c(5)) * c(2) - 2 * length * s(2) * c(345),
            -s(2) * (-d * s(3) + a - d * s(34)),
        ],
        2: [-s(345), -c(345), zero, -2 * length * c(345), 2 * length * s(345), d * c(34) + d * c(3)],
        3: [zero, zero, one, d * s(5) + d * s(45), d * c(5) + d * c(45), zero],
        4: [zero, zero, one, d * s(5), d * c(5), zero],
        5: [zero, zero, one, zero, zero, zero],
        6: [zero, -one, zero, zero, zero, zero],
        7: [-s(6), zero, c(6), -a * c(6), zero, -a * s(6)],
    }
    for j, column in columns.items():
        ours = found.columns[j - 1]
        for row, (x, y) in enumerate(zip([*ours[3:], *ours[:3]], column, strict=True)):
            assert equal(kg.ring, x, y), (j, row)


def test_the_basic_determinant_is_equation_7(found, kg):
    s, c, a, d = kg.s, kg.c, kg.a, kg.d
    expected = d**2 * s(4) * s(6) * (a * s(345) + d * c(34) + d * c(3))
    assert equal(kg.ring, determinant(found, range(2, 8)), expected)
    assert equal(kg.ring, found.start.basic.product.polynomial, SWAPPED * expected)
    first = [factor.whole for factor in found.start.basic.product.factors[:2]]
    assert [equal(kg.ring, *pair) for pair in zip(first, (s(4), s(6)), strict=True)] == [True, True]
    assert found.determinant == "−d² s4 s6 (a s345 + d c3 + d c34)"


def test_the_three_cases_suppress_the_screws_that_kg_does(found):
    said = [(case.dependence.screw, case.dependence.on) for case in found.start.cases]
    assert said == [(3, (4, 5)), (7, (3, 4, 5)), (2, (3, 4, 5, 6, 7))]


def test_case_1_leaves_equations_14_and_15(found, kg):
    s, c, a, length, d = kg.s, kg.c, kg.a, kg.c_, kg.d
    ring, c4 = kg.ring, kg.ring.c[4]
    case = found.start.cases[0]
    printed = (-c(2) * s(6) * a * c(3) + 2 * length * s(2) * s(3) * s(6) + s(2) * c(35) * a * c(5) * c(6)) * (
        a * s(35) * c4 + d * c(3) * c4 + d * c(3)
    ) + s(2) * (-a * c(35) * c4 + d * s(3) * c4 + d * s(3) - a) * (-2 * length * c(3) * s(6) + a * s(35) * c(5) * c(6))
    assert case.stratum.short(SWAPPED * case.basic.product.polynomial - d * c4 * printed) == 0
    (family,) = case.cases
    (_, condition) = found.families[family.family - 1].equalities
    # the bracket that is printed still holds the length a
    assert any(case.stratum.short(a * condition - unit * printed) == 0 for unit in (1, -1, c4, -c4))
    assert equal(ring, found.families[0].equalities[0], s(4))


def test_case_2_leaves_equation_19(found, kg):
    s, c, a, d = kg.s, kg.c, kg.a, kg.d
    expected = -(d**2) * s(2) * s(4) * (a * s(345) - d * c(45) - d * c(5))
    assert equal(kg.ring, determinant(found, range(1, 7)), expected)
    assert found.start.cases[1].stratum.short(SWAPPED * found.start.cases[1].basic.product.polynomial - expected) == 0


def test_case_3_is_proved_by_equation_22(found, kg):
    expected = -(kg.d**2) * kg.s(4) * kg.s(6)
    assert equal(kg.ring, determinant(found, range(3, 8), range(5)), expected)
    assert any(equal(kg.ring, p, sign * expected) for p in found.start.cases[2].dependence.proof.polynomials
               for sign in (1, -1))  # fmt: skip


def test_case_3_leaves_equation_25(found, kg):
    s, c, a, d = kg.s, kg.c, kg.a, kg.d
    expected = s(2) * d**2 * s(4) * s(6) * (-a * c(345) + d * s(3) - a + d * s(34))
    assert equal(kg.ring, determinant(found, (1, 3, 4, 5, 6, 7)), expected)
    assert equal(kg.ring, found.start.cases[2].basic.product.polynomial, SWAPPED * expected)


def test_there_are_five_families_with_the_conditions_of_equations_15_20_21_26_27(found, kg):
    s, c, a, d = kg.s, kg.c, kg.a, kg.d
    basic = a * s(345) + d * c(34) + d * c(3)
    printed = [
        ([s(6), s(2)], [s(4)]),  # 21
        ([s(6), a * s(345) - d * c(45) - d * c(5)], [s(4)]),  # 20
        ([basic, s(2)], [s(4), s(6)]),  # 27
        ([basic, -a * c(345) + d * s(3) - a + d * s(34)], [s(4), s(6)]),  # 26
    ]
    assert len(found.families) == 5
    for family, (zeros, others) in zip(found.families[1:], printed, strict=True):
        for conditions, expected in ((family.equalities, zeros), (family.stratum.open, others)):
            for p in expected:
                assert any(equal(kg.ring, p, sign * q) for q in conditions for sign in (1, -1))
        assert len(family.equalities) == len(zeros)
    # as printed, equation 20 meets 21 and 26 meets 27 where sin θ2 = 0: s2 ≠ 0 has to be added to one of each pair
    more = [len(family.stratum.open) for family in found.families[1:]]
    assert [n - len(others) for n, (_, others) in zip(more, printed, strict=True)] == [0, 1, 0, 1]
    assert found.families[0].stratum.open == ()


def test_no_two_families_meet(found):
    for one, two in combinations(found.families, 2):
        p = one.stratum.separating_polynomial(two.stratum)
        assert p is not None
        assert (p in one.stratum.equalities and p in two.stratum.inequalities) or (
            p in two.stratum.equalities and p in one.stratum.inequalities
        )


def test_every_family_loses_one_freedom(found):
    assert found.complete
    assert [family.ranks for family in found.families] == [(5,)] * 5


def test_there_are_no_denominators(found):
    for family in found.families:
        for p in family.equalities + family.stratum.open:
            assert all(int(value.q) == 1 for value in p.coeffs())
    assert found.assumptions == ()


@pytest.mark.slow
def test_the_frame_and_the_basic_screws_chosen_agree_with_kgs_families():
    chosen = suppress(exact_chain(open_robot("canadarm2"), lengths=LENGTHS))
    asked = suppress(exact_chain(open_robot("canadarm2"), lengths=LENGTHS), frame=5, basic=range(2, 8))
    assert chosen.basic == (2, 3, 4, 5, 6, 7)
    assert [list(map(str, f.equalities[:1])) for f in chosen.families] == [
        list(map(str, f.equalities[:1])) for f in asked.families
    ]


@pytest.mark.slow
def test_the_steps_read_as_the_paper_does(found):
    told = {step.title: step.lines for step in steps_of(found.chain, found)}
    assert told["Screws"][3] == "$2 = (−2 c c345, 2 c s345, d c3 + d c34; −s345, −c345, 0)"
    first = told["Step 1: the determinant of the basic screws"]
    assert first[0] == "basic screws: $2 $3 $4 $5 $6 $7, independent in general; 3, 4, 5 are a planar joint"
    assert first[1] == "why these: asked for"
    assert first[2] == "|$2 $3 $4 $5 $6 $7| = −d² s4 s6 (a s345 + d c3 + d c34)"
    assert first[3:] == (
        "case 1: s4 = 0",
        "case 2: s6 = 0, s4 ≠ 0",
        "case 3: a s345 + d c3 + d c34 = 0, s4 ≠ 0, s6 ≠ 0",
    )
    second = told["Case 2: s6 = 0, s4 ≠ 0"]
    assert second[:3] == (
        "here $7 = (−a c6, 0, 0; 0, 0, c6)",
        "$7 is a combination of $3 $4 $5, which are independent:",
        "|$3 $4 $5| of rows vx vy wz is d² s4 ≠ 0",
    )
    assert second[-2:] == (
        "family 2: s2 = 0, s6 = 0, s4 ≠ 0",
        "family 3: s6 = 0, a s345 − d c45 − d c5 = 0, s4 ≠ 0, s2 ≠ 0",
    )
    assert told["Families"][-3:] == (
        "s4 = 0 in 1, not in 2, 3, 4, 5",
        "s2 = 0 in 2, 4, not in 3, 5",
        "s6 = 0 in 2, 3, not in 4, 5",
    )
