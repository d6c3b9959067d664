"""Conditions that people write: read exactly, refused with the place of the mistake, never evaluated."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from rankdrop.algebra.polynomial import SIMPLE
from rankdrop.algebra.ring import Ring
from rankdrop.errors import OptionError
from rankdrop.formula.notation import Python
from rankdrop.formula.reading import Parsed, parse_conditions
from rankdrop.formula.writing import AnglePin, Condition

LETTERS = {"a2": 0.4, "a3": -0.3, "c": 1.7}


@pytest.fixture(scope="module")
def ring():
    return Ring([1, 2, 3, 4, 5], [6], list(LETTERS))


def parse_condition(text: str, ring: Ring, **options) -> Parsed:
    """The only condition of a text."""
    (found,) = parse_conditions(text, ring, **options)
    return found


@pytest.mark.parametrize(
    ("text", "python"),
    [
        ("sin(q3)*(a2*cos(q2)+a3*cos(q2+q3))", None),
        ("s3 (a2 c2 + a3 c23)", "sin(q3)*(a2*cos(q2)+a3*cos(q2+q3))"),
        ("a2 s3 = −a3 c345", "a2*sin(q3) + a3*cos(q3+q4+q5)"),
        ("c5² + cos²(θ3 + θ4/2) − 1", "cos(q5)**2 + cos(q3 + q4/2)**2 - 1"),
        ("c (s3 + s5)", "c*(sin(q3) + sin(q5))"),
        ("2.5e-1*sin(2*theta3 - th1)/4 · q6^2", "0.25*sin(2*q3 - q1)/4*q6**2"),
        ("cos(q3 - π/2 + pi)", "cos(q3 + pi/2)"),
        ("sin((q3 - pi/2)/2)", None),
        ("3 cos((q3 + q5 + pi)/2)", "3*cos((q3+q5+pi)/2)"),
        ("-(-sin(-q1))*-2", "sin(-q1)*(-2)"),
        ("sin θ3 - cos q1", "sin(q3) - cos(q1)"),
        ("q6 = 0.2", "q6 - 0.2"),
        ("c(2θ3) + s(θ3 − θ5)", "cos(2*q3)"),
    ],
)
def test_value_is_that_of_python(ring, text, python):
    if "c(2" in text:  # c is a length of this arm
        ring = Ring([3, 5])
        python = "cos(2*q3) + sin(q3-q5)"
    parsed = parse_condition(text, ring)
    rng = np.random.default_rng(2)
    theta = rng.uniform(-3, 3, (5, 6))
    values = parsed(theta, LETTERS)
    for row, value in zip(theta, values, strict=True):
        scope = {"sin": math.sin, "cos": math.cos, "pi": math.pi} | LETTERS
        wanted = eval(python or text, scope | {f"q{j}": x for j, x in enumerate(row, 1)})
        assert value == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize(
    ("text", "keys"),
    [
        ("θ4 = 0 or π", ["θ4=pi", "θ4=0"]),
        ("q4 = ±pi/2", ["θ4=pi/2", "θ4=-pi/2"]),
        ("θ5 = θ3 + π", ["t3*t5 + 1"]),
        ("θ3 + θ5 = 0", ["t3 + t5"]),
        ("q4", ["θ4=0"]),
        ("2 q4 = pi", ["θ4=pi/2", "θ4=-pi/2"]),
        ("cos(q4/2)", ["θ4=pi"]),
        ("1 + c4", ["θ4=pi"]),
        ("s3**2 + c3**2 + 3", []),
        ("a2 + a3", []),
    ],
)
def test_irreducible_parts(ring, text, keys):
    assert [atom.key for atom in parse_condition(text, ring).atoms] == keys


def test_several_conditions(ring):
    found = parse_conditions("q6 = 0.2; s3, c4 and sin(q1) = 0;", ring)
    assert [one.text for one in found] == ["q6 = 0.2", "s3", "c4", "sin(q1) = 0"]


def test_what_always_holds_and_what_holds_for_special_lengths_is_told(ring):
    assert parse_condition("s3^2 + c3^2 - 1", ring).form.f == 0
    assert [str(f) for f in parse_condition("(a2 - c) s3", ring).letters] == ["a2 - c"]


@pytest.mark.by_hand
def test_what_is_printed_is_read_back(ring):
    rng = random.Random(0)
    for _ in range(10):
        f = ring.half.from_dict(
            {tuple(rng.randint(0, 1) for _ in ring.names): rng.randint(-5, 5) or 2 for _ in range(5)}
        )
        condition = Condition(ring, f)
        wanted = parse_condition(condition.code(Python()), ring).atoms
        assert {atom.key for atom in wanted} == {atom.key for atom in parse_condition(condition.text(), ring).atoms}
        kept = [factor for factor, _ in f.factor()[1] if factor.degrees()[: ring.moving] != (0,) * ring.moving]
        assert {ring.atom(factor).key for factor in kept if not ring.is_unit(factor)} >= {
            atom.key for atom in wanted if not atom.is_pin
        }
        assert wanted
    for values in [("0", "pi"), ("pi/2", "-pi/2"), ("-pi/2",), ("pi",), ("0", "pi/2"), SIMPLE]:
        for text in (AnglePin(4, values).text(), AnglePin(4, values).code(Python())):
            assert {atom.value for atom in parse_condition(text, ring).atoms} == set(values)


def test_shifted_joints_are_exact_with_their_shift_only(ring):
    shifts = [0, 0.3, 0, 0, 0, 0]
    read = parse_condition("sin(q2 + 0.3)", ring, shifts=shifts)
    assert [atom.key for atom in read.atoms] == ["θ2=pi", "θ2=0"]
    assert parse_condition("sin(θ2)", ring, shifts=shifts).form.f == read.form.f
    with pytest.raises(OptionError, match=r"θ2 = q2 \+ 0\.3 rad"):
        parse_condition("sin(q2)", ring, shifts=shifts)


def test_lengths_are_numbers_or_letters():
    with pytest.raises(OptionError, match="write numbers"):
        parse_condition("a2*sin(q1)", Ring([1]))
    assert parse_condition("0.1*sin(q1) + 0.3", Ring([1])).form.f == parse_condition("s1/10 + 3/10", Ring([1])).form.f


MISTAKES = [
    ("", "ends too early", 1),
    ("   ", "ends too early", 4),
    ("sin(", "ends too early", 5),
    ("a2*", "ends too early", 4),
    ("((((s3", "opened at column 4", 7),
    ("sin(q9)", "no joint 9", 5),
    ("foo", "'foo' is not known", 1),
    ("a2c2", "'a2c2' is not known", 1),
    ("q3*s4", "angle stands|no angle|numbers only", 4),
    ("s3 + q4 s1", "no angle", 1),
    ("sin(q3+0.2)", "not exact", 1),
    ("sin(q3/3)", "whole or half multiple", 1),
    ("sin(q3 q4)", "numbers only", 8),
    ("sin(sin(q3))", "no angle", 5),
    ("sin(q6)", "no angle", 5),
    ("1/0 + s3", "numbers only", 3),
    ("s3/(a2)", "numbers only", 5),
    ("s3**a2", "whole number", 5),
    ("s3**99999999999", "too high", 5),
    ("s3**0.5", "whole number", 5),
    ("1e99999", "too long", 1),
    ("9" * 5000, "too long", 1),
    ("s3 $ 4", "means nothing", 4),
    ("s3 \u202e", "means nothing", 4),
    ("\x00", "means nothing", 1),
    ("٣ s3", "means nothing", 1),
    ("s3 s3)", "does not belong", 6),
    ("=", "does not belong", 1),
    ("s3 = 0 = 1", "does not belong", 8),
    ("s3 = 0 or 1", "values of an angle", 11),
    ("±s3", "values of an angle", 1),
    ("sin(q3)+sin(q3/2)", "full turns", 1),
    ("sin(q3/2 - pi/4) + cos(q3/2)", "do not add up exactly", 1),
    ("__import__('os').system('true')", "means nothing", 1),
    ("(lambda: 0)()", "'lambda' is not known|means nothing", 8),
    ("(s1+s2+s3+s4+s5+a2+a3+q6)**40", "too many terms", 2),
    ("sin(20 q1)**40", "too high powers", 1),
    ("(" * 5000 + "s1" + ")" * 4990, "nested too deeply", 61),
]


@pytest.mark.parametrize(("text", "what", "column"), MISTAKES, ids=[text[:20] for text, _, _ in MISTAKES])
def test_mistakes_are_refused_with_their_place(ring, text, what, column):
    with pytest.raises(OptionError, match=what) as caught:
        parse_conditions(text, ring)
    assert caught.value.where == f"condition, column {column}"
    assert "▸" in caught.value.got
    assert len(str(caught.value)) < 500


def test_too_long_is_refused(ring):
    with pytest.raises(OptionError, match="too long"):
        parse_conditions("s1+" * 10_000 + "s1", ring)


def test_any_text_is_read_or_refused(ring):
    rng = random.Random(1)
    pieces = ["s3", "q4", "θ2", "(", ")", "+", "-", "*", "/", "**", "2", "pi", "sin", "cos", "=", ";", "or", "and",
              "a2", "²", "±", ".5", "\n", "c", "q6", ","]  # fmt: skip
    read, places = 0, []
    for _ in range(1500):
        text = " ".join(rng.choice(pieces) for _ in range(rng.randint(1, 9)))
        try:
            parse_conditions(text, ring)
            read += 1
        except OptionError as error:
            places.append(error.where)
    assert read > 20
    assert places
    assert all(place.startswith("condition, column") for place in places)
