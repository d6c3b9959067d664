"""Every condition as it is written (text, LaTeX, Python, C) is its polynomial up to one number, at random real points.

Arms with twists of 15°, 30°, 45° and 60°, whose conditions contain √2, √3 and more, and some of the catalogue. Texts
are read back, the code is run; the polynomial is evaluated by its own terms in half-angle tangents.
"""

from __future__ import annotations

import re
from math import cos, prod, sin

import numpy as np
import pytest

from rankdrop.algebra.polynomial import reduced_roots
from rankdrop.algebra.ring import Ring
from rankdrop.exact.letters import letters_text
from rankdrop.families.record import exact_of
from rankdrop.formula.notation import SUPERSCRIPT, C, Python
from rankdrop.formula.reading import read
from rankdrop.formula.sums import half_of
from rankdrop.formula.writing import Condition
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.verbs.conditions import conditions

ROWS = {  # (a, alpha in degrees, d), standard convention
    "45 and 30": ([(0, -90, 0.272), (0, 45, 0.151), (0, 30, 0.141), (0, 90, 0.401), (0.419, 90, 0), (0, 0, 0.253)],
                  "pose"),
    "45 and 60": ([(0.3, 60, 0.1), (0.4, 90, 0.2), (0.25, 45, 0.1), (0.2, 0, 0)], "position"),
    "60": ([(0.3, 60, 0.1), (0.4, 60, 0.2), (0.25, 60, 0.1), (0.2, 0, 0)], "position"),
    "15": ([(0, 15, 0.2), (0.3, 90, 0), (0, 15, 0.1), (0.25, 0, 0)], "position"),
    "wrist at 60": ([(0, -90, 0.3), (0.5, 0, 0), (0, 90, 0), (0, 60, 0.4), (0, -60, 0), (0, 0, 0.1)], "pose"),
}  # fmt: skip
CATALOGUE = ("j2n6s300", "m1n6s200", "ur5e", "crx10ia")


def found(name):
    if name in CATALOGUE:
        return conditions(open_robot(name), method="tree", points=0)
    rows, task = ROWS[name]
    table = [{"a": a, "alpha": np.radians(alpha), "d": d} for a, alpha, d in rows]
    return conditions(from_dh(table, convention="standard", name=name), task, method="tree", points=0)


def half_angle_value(condition, theta, letters):
    """The polynomial over Π (1 + t²)^(D/2), term by term."""
    ring, f = condition.ring, condition.polynomial
    degrees = f.degrees()
    total = size = 0.0
    for powers, number in f.terms():
        one = int(number.p) / int(number.q)
        for place, (name, e) in enumerate(zip(ring.names, powers, strict=True)):
            if place < ring.angles:
                x = theta[ring.revolute[place] - 1] / 2
                one *= sin(x) ** int(e) * cos(x) ** int(degrees[place] - e)
            elif place < ring.moving:
                one *= theta[ring.prismatic[place - ring.angles] - 1] ** int(e)
            else:
                one *= letters[name] ** int(e)
        total, size = total + one, size + abs(one)
    return total, size


def plain(latex):
    """LaTeX in the signs of the text."""
    text = re.sub(r"\^\\circ", "°", latex)
    text = re.sub(r"\^\{(\d+)\}", lambda m: m[1].translate(SUPERSCRIPT), text)
    for _ in range(3):
        text = re.sub(r"\\t?frac\{([^{}]*(?:\{[^{}]*\}[^{}]*)*)\}\{([^{}]*)\}", r"((\1)/\2)", text)
    text = re.sub(r"\\sqrt\{(\d)\}", r"√\1", text).replace(r"\theta", "θ").replace(r"\pi", "π")
    text = re.sub(r"([A-Za-zθ])_\{?(\w+)\}?", r"\1\2", text)
    text = re.sub(r" \\cdot 10\^?\{?(-?\d+)\}?", r"e\1", text)
    return text.replace("\\", "").replace("-", "−")


def text_value(text, theta, letters):
    """The left side less the right one of a condition as people read it."""
    text = re.sub(r"cos 18°", repr(float(cos(np.pi / 10))), text)
    text = re.sub(r"√(\d)", lambda m: repr(int(m[1]) ** 0.5), text)
    (tree,) = read(text, frozenset(letters))
    left, *right = (number_at(part, theta, letters) for part in tree.parts)
    return left - (right[0] if right else 0.0)


def number_at(node, theta, letters):
    parts = [number_at(part, theta, letters) for part in node.parts]
    if node.kind == "number":
        return float(node.number)
    if node.kind == "name":
        return named(node.name, theta, letters)
    if node.kind == "**":
        return parts[0] ** int(node.number)
    if node.kind in ("sin", "cos"):
        return {"sin": sin, "cos": cos}[node.kind](parts[0])
    if node.kind == "-":
        return -parts[0] if len(parts) == 1 else parts[0] - parts[1]
    return {"+": sum, "*": prod, "/": lambda p: p[0] / p[1] if len(p) > 1 else 1 / p[0]}[node.kind](parts)


def named(name, theta, letters):
    if name in letters:
        return letters[name]
    if name in ("π", "pi"):
        return np.pi
    if name[0] in "θq":
        return theta[int(name[1:]) - 1]
    return {"s": sin, "c": cos}[name[0]](sum(theta[int(j) - 1] for j in name[1:]))


def wrong(result):
    """What is written of each condition and is not the polynomial times one number, at random real points."""
    rng = np.random.default_rng(7)
    n = result.robot.n
    told = []
    for family in result.families:
        exact = exact_of(family)
        letters, shifts = exact.numbers, np.array(exact.shifts)
        for one in exact.polynomials:
            if len(one.polynomial) > 400:
                continue
            points = rng.uniform(-3.0, 3.0, (6, n))
            wanted = np.array([half_angle_value(one, theta, letters) for theta in points])
            python, c = (one.code(notation(shifts=tuple(shifts))) for notation in (Python, C))
            ways = {
                "python": [run(python, theta - shifts, letters) for theta in points],
                "C": [run(c, theta - shifts, letters) for theta in points],
            }
            if one.relation is None:
                ways["text"] = [text_value(one.text(), theta, letters) for theta in points]
                ways["LaTeX"] = [text_value(plain(one.latex()), theta, letters) for theta in points]
            for way, values in ways.items():
                scale = np.linalg.lstsq(wanted[:, :1], np.array(values), rcond=None)[0][0]
                gap = np.abs(np.array(values) - scale * wanted[:, 0])
                if (gap > (1e-9 if way in ("python", "C") else 1e-4) * abs(scale) * wanted[:, 1]).any():
                    told.append((family.id, way, one.text()))
    return told


def run(code, q, letters):
    space = {"sin": sin, "cos": cos, "pow": pow, "pi": np.pi, "q": q, **{f"q{j}": x for j, x in enumerate(q, 1)}}
    return float(eval(code, {}, {**space, **letters}))


@pytest.mark.spread(1)
@pytest.mark.by_hand_at("15", "45 and 30", "45 and 60", "60", "j2n6s300", "m1n6s200", "ur5e")
@pytest.mark.slow_at("45 and 30", "j2n6s300", "m1n6s200", "45 and 60", "crx10ia", "ur5e", "60", "15", "wrist at 60")
@pytest.mark.parametrize("name", [*ROWS, *CATALOGUE])
def test_what_is_written_is_the_polynomial(name) -> None:
    result = found(name)
    assert result.families
    assert wrong(result) == []


@pytest.mark.slow
def test_forms_of_polynomials_with_roots_are_equal_to_them() -> None:
    rng = np.random.default_rng(0)
    ring = Ring([1, 2, 3], letters=["a", "sqrt2", "sqrt3"])
    for _ in range(3):
        f = ring.half.constant(0)
        for powers in rng.integers(0, 3, (4, len(ring.names))):
            powers[ring.angles :] = np.minimum(powers[ring.angles :], 1)
            f += ring.half.from_dict({tuple(map(int, powers)): int(rng.integers(1, 9))})
        f = f * (1 + ring.t[3] * ring.letter_half["sqrt2"])  # several factors
        whole = Condition(ring, f).form
        back = half_of(whole, ring)
        assert ratio_of(ring, back.f, f) == 1


def ratio_of(ring, one, two):
    """one / two where that is a number, up to factors 1 + t²."""
    for j, have, own in zip(ring.revolute, one.degrees(), two.degrees(), strict=False):
        two = two * (1 + ring.t[j] ** 2) ** max((int(have) - int(own)) // 2, 0)

    return 1 if reduced_roots(one - two) == 0 else 0


def test_a_minus_stands_before_a_whole_sum() -> None:
    """A KR 6 on a rail is real where a4² + d5² − a2² ≥ 0; a minus before a2² − a4² − d5² without brackets is wrong."""
    ring = Ring([1], letters=["a2", "a4", "d5"])
    a2, a4, d5 = (ring.letter_half[name] for name in ("a2", "a4", "d5"))
    assert letters_text(ring, a4**2 + d5**2 - a2**2) == "−a2² + a4² + d5²"
    assert letters_text(ring, 3 * (a2**2 - a4**2 - d5**2)) == "a2² − a4² − d5²"
    assert letters_text(ring, -4 * (a2 + d5) ** 2) == "−(a2 + d5)²"
    assert letters_text(ring, -4 * a2**2) == "−a2²"
