"""Conditions that a person wrote, read without rounding and without evaluating text: text to tokens, tree, polynomials.

    conditions  = condition {(";" | "," | "and") condition}
    condition   = sum ["=" sum {"or" sum}]
    sum         = ["-"] product {("+" | "-") product}
    product     = power {["*"] power | "/" power}          a2 c2 is a2*c2
    power       = primary [("**" | "^") whole number]      c5² too
    primary     = number | name | "(" sum ")" | "±" power
                | ("sin" | "cos" | "s" | "c") [power] ("(" sum ")" | name)

`read` makes the trees, with the place of every mistake. `Meaning` makes functions on the torus of them, exactly, or
angles as combinations of joint angles.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, reduce
from math import pi
from operator import add

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.algebra.polynomial import Atom, Polynomial, flint
from rankdrop.algebra.ring import Form, Ring, add_terms, numeric_terms
from rankdrop.errors import OptionError
from rankdrop.formula.sums import Product, Wave, add_forms, half_of, number_of, wave
from rankdrop.robot.model import Array

LONGEST = 10_000
"""Characters of a condition."""
DEEPEST = 60
"""Brackets in brackets."""
DIGITS = 40
"""Of a number."""
HIGHEST = 40
"""Power."""
WAVES = {"sin": "sin", "cos": "cos", "s": "sin", "c": "cos"}
_LOWERED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789")
_SIGNS = {"−": "-", "–": "-", "·": "*", "×": "*", "^": "**"}
_TOKEN = re.compile(
    r"(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[A-Za-zθπ][A-Za-z0-9_]*)|(?P<raised>[⁰¹²³⁴⁵⁶⁷⁸⁹]+)"
    r"|(?P<sign>\*\*|[-+*/^()=;,±−–·×])|(?P<space>\s+)|(?P<other>.)",
    re.DOTALL,
)

_KNOWN = re.compile(r"[qθsct]\d+|pi|π")
"""Names that a bracket may follow as a factor: s2 (a2 + a3)."""

TURNED = 1e-9
"""Decimals of an angle within this of a quarter turn, shifts of joints added, are that quarter turn [rad]."""
LARGEST = 20_000
"""Terms a polynomial may have while a condition is read."""
HIGH = 80
"""Degree in the half-angle tangent of a joint while a condition is read."""

PI, ONE = 0, -1
Angle = dict[int, Fraction]
"""A combination of angles: what θ_j, π (`PI`) and the number 1 (`ONE`) are multiplied by; zeros are left out."""


@dataclass(frozen=True, slots=True)
class Node:
    """A piece of the tree; before there is one, a piece of the text.

    Attributes:
        kind: "number", "name", "sin", "cos", "+", "-" (two parts or one), "*", "/", "**", "±"; "=" of a condition,
            whose parts are its left side and the right ones (none: the left one is zero); of text also "raised", "sign"
            and "end".
        place: where it starts in the text, from 0.
        parts: what it is made of.
        name: of a name; of a condition or of text as it is written, signs of text in ASCII.
        number: of a number, or the whole power of "**".
    """

    kind: str
    place: int
    parts: tuple[Node, ...] = ()
    name: str = ""
    number: Fraction = Fraction(0)


def wrong(
    text: str, place: int, what: str, *, allowed: str | None = None, mend: str | None = None
) -> OptionError:
    """The error for a mistake at a place of the text, which is shown with a mark before the mistake."""
    start, stop = max(0, place - 30), min(len(text), place + 20)
    before, after = text[start:place], text[place:stop]
    shown = f"{'…' if start else ''}{before}▸{after}{'…' if stop < len(text) else ''}"
    return OptionError(what, where=f"condition, column {place + 1}", got=repr(shown), allowed=allowed, mend=mend)


def read(text: str, letters: frozenset[str] = frozenset()) -> tuple[Node, ...]:
    """The conditions of a text.

    Args:
        text: as in the grammar above.
        letters: names of lengths; one called s or c is that length before a bracket, too.

    Raises:
        OptionError: the text does not follow the grammar, or is too long or too deep.
    """
    if len(text) > LONGEST:
        raise OptionError("the condition is too long", got=f"{len(text)} characters", allowed=f"up to {LONGEST}")
    return _FormulaReader(text, letters).statements()


def _tokens(text: str) -> list[Node]:
    tokens = []
    for match in _TOKEN.finditer(text):
        kind = match.lastgroup or ""
        if kind == "other":
            raise wrong(
                text, match.start(), "a character that means nothing in a condition",
                allowed="+ − * / ** ( ) = ; ,",
            )  # fmt: skip
        if kind != "space":
            tokens.append(Node(kind, match.start(), name=_SIGNS.get(match.group(), match.group())))
    return [*tokens, Node("end", len(text))]


class _FormulaReader:
    def __init__(self, text: str, letters: frozenset[str]) -> None:
        self.text, self.letters = text, letters
        self.tokens = _tokens(text)
        self.at, self.depth = 0, 0

    @property
    def token(self) -> Node:
        return self.tokens[self.at]

    def take(self, *texts: str) -> Node | None:
        """The token where it is one of these signs or words; then the next one is looked at."""
        token = self.token
        if token.name in texts and token.kind in ("sign", "name"):
            self.at += 1
            return token
        return None

    def statements(self) -> tuple[Node, ...]:
        """Condition { (; | , | and) Condition }, to the end; a Condition is a Sum [= Sum { or Sum }]."""
        nodes = []
        while True:
            start, sides = self.token.place, [self.sum()]
            if self.take("="):
                sides.append(self.sum())
                while self.take("or"):
                    sides.append(self.sum())
            nodes.append(Node("=", start, tuple(sides), self.text[start : self.token.place].strip()))
            ended = self.token.kind == "end"
            if ended:
                separator = None
            else:
                separator = self.take(";", ",", "and")
            if separator is None and not ended:
                raise self.unexpected_part("an operator or the end")
            if ended or (self.token.kind == "end" and separator is not None and separator.name == ";"):
                return tuple(nodes)

    def unexpected_part(self, allowed: str) -> OptionError:
        ended = self.token.kind == "end"
        return wrong(
            self.text, self.token.place, "the condition ends too early" if ended else "this does not belong here",
            allowed=allowed,
        )  # fmt: skip

    def sum(self) -> Node:
        """[±] Product { (+ | −) Product }."""
        sign, parts = self.take("-", "+"), list[Node]()
        while not parts or sign is not None:
            part = self.product()
            negative = sign is not None and sign.name == "-"
            parts.append(Node("-", sign.place, (part,)) if sign is not None and negative else part)
            sign = self.take("+", "-")
        return _join_parts("+", parts)

    def product(self) -> Node:
        """Power { [* | /] Power }: side by side is a product, too; a factor after a sign may have a −."""
        parts = [self.power()]
        while (sign := self.take("*", "/")) is not None or self.starts_primary():
            if sign is not None:
                minus = self.take("-")
            else:
                minus = None
            part = self.power()
            if minus is None:
                part = part
            else:
                part = Node("-", minus.place, (part,))
            parts.append(Node("/", part.place, (part,)) if sign is not None and sign.name == "/" else part)
        return _join_parts("*", parts)

    def starts_primary(self) -> bool:
        if self.token.kind == "name":
            return self.token.name not in ("and", "or")
        return self.token.kind == "number" or self.token.name == "("

    def power(self) -> Node:
        """Primary [** whole number]."""
        return self.raise_to_power(self.primary(), self.exponent())

    def raise_to_power(self, node: Node, exponent: Fraction | None) -> Node:
        if exponent is None:
            return node
        return Node("**", node.place, (node,), number=exponent)

    def exponent(self) -> Fraction | None:
        """A raised number, or what stands after **; None where neither does."""
        if self.token.kind == "raised":
            digits = self.token.name.translate(_LOWERED)
        elif self.take("**") is None:
            return None
        else:
            digits = self.token.name
            if self.token.kind != "number" or not digits.isdecimal():
                raise wrong(self.text, self.token.place, "a power must be a whole number", allowed=f"0 … {HIGHEST}")
        if len(digits) > 4 or int(digits) > HIGHEST:
            raise wrong(self.text, self.token.place, "the power is too high", allowed=f"0 … {HIGHEST}")
        self.at += 1
        return Fraction(digits)

    def name_or_wave(self, token: Node) -> Node:
        """A name that was taken, or the sine or cosine that begins with it."""
        bracket = self.token.name == "(" or self.token.kind == "raised"
        if token.name in ("sin", "cos") or (token.name in WAVES and bracket and token.name not in self.letters):
            return self.wave(token)
        if self.token.name == "(" and token.name not in self.letters and not _KNOWN.fullmatch(token.name):
            raise wrong(self.text, token.place, f"there is no function {token.name}", allowed="sin, cos, s, c")
        return token

    def primary(self) -> Node:
        token = self.token
        if token.kind == "number":
            self.at += 1
            return Node("number", token.place, number=self.value(token))
        if token.kind == "name" and token.name not in ("and", "or"):
            self.at += 1
            return self.name_or_wave(token)
        if self.take("±"):
            return Node("±", token.place, (self.power(),))
        if token.name == "(":
            return self.bracket()
        raise self.unexpected_part("a number, a name, sin, cos, or a bracket")

    def wave(self, token: Node) -> Node:
        """What follows sin or cos: an exponent, if there is one, and a bracket or a name."""
        exponent = self.exponent()
        if self.token.name == "(":
            inside = self.bracket()
        elif self.token.kind == "name" and self.token.name not in (*WAVES, "and", "or"):
            inside = self.token
            self.at += 1
        else:
            raise wrong(self.text, self.token.place, f"{token.name} needs an angle", allowed=f"{token.name}(q1 + q2)")
        return self.raise_to_power(Node(WAVES[token.name], token.place, (inside,)), exponent)

    def bracket(self) -> Node:
        opened = self.token
        self.at += 1
        self.depth += 1
        if self.depth > DEEPEST:
            raise wrong(self.text, opened.place, "brackets are nested too deeply", allowed=f"up to {DEEPEST}")
        node = self.sum()
        if self.take(")") is None:
            raise self.unexpected_part(f"an operator, or the ) of the bracket opened at column {opened.place + 1}")
        self.depth -= 1
        return node

    def value(self, token: Node) -> Fraction:
        digits, _, power = token.name.lower().partition("e")
        if len(digits) > DIGITS or len(power) > 3:
            raise wrong(
                self.text, token.place, "the number is too long",
                allowed=f"{DIGITS} digits, powers of ten up to 99",
            )  # fmt: skip
        return Fraction(token.name)


def _join_parts(kind: str, parts: Sequence[Node]) -> Node:
    if len(parts) == 1:
        return parts[0]
    return Node(kind, parts[0].place, tuple(parts))


def _combine_angles(one: Angle, two: Angle, factor: Fraction = Fraction(1)) -> Angle:
    """one + factor · two."""
    values = {key: one.get(key, Fraction(0)) + factor * two.get(key, Fraction(0)) for key in (*one, *two)}
    return {key: value for key, value in values.items() if value}


@dataclass(frozen=True)
class Parsed:
    """A condition, or a part of one, as a function on the torus: f · √2^root / Π (1 + t_j²)^(D_j / 2).

    Attributes:
        form: f, not factored, and the D_j.
        root: 0 or 1.
        text: as written; "" for a part.
    """

    form: Form
    root: int = 0
    text: str = ""

    @cached_property
    def atoms(self) -> tuple[Atom, ...]:
        """The irreducible conditions that it is zero under; none where it is never zero.

        Raises:
            ZeroDivisionError: f is zero everywhere.
        """
        if self.form.f == 0:
            raise ZeroDivisionError("a condition that always holds has no irreducible parts")
        return tuple(atom for atom, _ in self.form.factors().atoms)

    @cached_property
    def letters(self) -> tuple[Polynomial, ...]:
        """Factors in lengths alone: for special lengths the condition always holds."""
        if self.form.f == 0:
            return ()
        return tuple(factor for factor, _ in self.form.factors().letters)

    def __call__(self, theta: ArrayLike, letters: dict[str, float]) -> Array:
        """The value at angles.

        Args:
            theta: (..., n) angles [rad], variables of slides [m].
            letters: value of each length [m].

        Returns:
            (...,) values.
        """
        form = self.form
        if form.f == 0:
            return np.zeros(np.shape(theta)[:-1])
        powers = form.ring.powers_at(form.f, np.asarray(theta, dtype=np.float64), form.degrees)
        return add_terms(numeric_terms(form.f, letters, unit=flint().fmpq(1)), powers) * 2 ** (self.root / 2)


class Meaning:
    """Meaning of trees in a ring."""

    def __init__(self, text: str, ring: Ring, shifts: Sequence[float] | None) -> None:
        self.text, self.ring = text, ring
        self.shifts = np.zeros(max([*ring.revolute, *ring.prismatic], default=0)) if shifts is None else shifts

    def statement(self, statement: Node) -> Parsed:
        """One condition."""
        left, *rights = statement.parts
        if any(map(self.is_angle, statement.parts)):
            return self.relation(left, rights)
        if len(rights) > 1:
            raise wrong(
                self.text, rights[1].place, "“or” stands between values of an angle only",
                allowed="θ4 = 0 or π",
            )  # fmt: skip
        value = self.value(left)
        if rights:
            return self.sum([value, self.negative(self.value(rights[0]))], rights[0])
        return value

    # angles

    def is_angle(self, node: Node) -> bool:
        """Whether a turning joint's variable stands in it outside sin and cos."""
        if node.kind == "name":
            joint = self.joint(node)
            return joint is not None and joint in self.ring.revolute
        return node.kind not in ("sin", "cos") and any(self.is_angle(part) for part in node.parts)

    def relation(self, left: Node, rights: Sequence[Node]) -> Parsed:
        """Σ m_j θ_j = value, modulo 2π."""
        halves = []
        signed = [node for right_side in rights for node in _both_signs(right_side)]
        for right in signed or [Node("number", left.place)]:
            angle = _combine_angles(self.angle(left), self.angle(right), Fraction(-1))
            turns = [m for j, m in angle.items() if j > PI]
            if not turns or any(m.denominator != 1 for m in turns):
                raise wrong(self.text, left.place, "an equation of angles needs whole multiples of them on it")
            halves.append((self.wave("sin", _combine_angles({}, angle, Fraction(1, 2)), left), left))
        return self.product(halves)

    def angle(self, node: Node) -> Angle:
        """The tree as an angle."""
        if node.kind == "number":
            if node.number:
                return {ONE: node.number}
            return {}
        if node.kind == "name":
            return self.named_angle(node)
        if node.kind == "-":
            return _combine_angles({}, self.angle(node.parts[0]), Fraction(-1))
        if node.kind == "+":
            return reduce(_combine_angles, (self.angle(part) for part in node.parts))
        if node.kind == "*":
            return self.multiple_of_angle(node)
        raise wrong(self.text, node.place, "this is no angle", allowed="multiples of joint angles, pi, numbers")

    def multiple_of_angle(self, node: Node) -> Angle:
        """A product as an angle: numbers, and one angle at most."""
        number, kept = Fraction(1), {ONE: Fraction(1)}
        for part in node.parts:
            angle = self.angle(part.parts[0] if part.kind == "/" else part)
            plain = angle.keys() <= {ONE}
            if part.kind == "/":
                if not plain or not angle:
                    raise wrong(self.text, part.place, "an angle is divided by numbers only, not by 0")
                number /= angle[ONE]
            elif plain:
                number *= angle.get(ONE, Fraction(0))
            elif kept.keys() - {ONE}:
                raise wrong(self.text, part.place, "angles are multiplied by numbers only")
            else:
                kept = angle
        return _combine_angles({}, kept, number)

    def named_angle(self, node: Node) -> Angle:
        """π, q3 or θ3."""
        if node.name in ("pi", "π"):
            return {PI: Fraction(1)}
        joint = self.joint(node)
        if joint is None or joint not in self.ring.revolute:
            raise wrong(self.text, node.place, "this is no angle", allowed=self.angles())
        if node.name[0] == "q":
            shift = Fraction(float(self.shifts[joint - 1]))
        else:
            shift = Fraction(0)
        part = self.ring.parts.get(joint, 1)
        return _combine_angles({joint: Fraction(part)}, {ONE: -shift})  # q = θ − shift, θ = part · the ring's angle

    def angles(self) -> str:
        """The names of angles that may be used."""
        return ", ".join([*(f"q{j}" for j in self.ring.revolute), "θ for q", "pi"])

    def wave(self, kind: str, angle: Angle, node: Node) -> Parsed:
        """sin or cos of an angle."""
        turns = {j: 2 * m for j, m in angle.items() if j > PI}
        decimal = float(angle.get(ONE, 0))
        for j, m in turns.items():
            if m.denominator != 1 or abs(m) > 40:
                raise wrong(
                    self.text, node.place, f"{m / 2} θ{j} is no whole or half multiple of the angle, up to 20",
                )  # fmt: skip
        if abs(decimal - round(decimal / (pi / 4)) * pi / 4) > TURNED:
            raise self.not_exact(angle, node)
        eighths = angle.get(PI, Fraction(0)) * 4 + round(decimal / (pi / 4))
        if eighths.denominator != 1:
            raise wrong(self.text, node.place, "this angle is not exact", allowed="whole numbers of pi/2, or of pi/4")
        whole = {j: int(m) for j, m in turns.items()}
        wave = self.waves_of(kind, whole, int(eighths) // 2)
        if int(eighths) % 2:  # f(φ + π/4) = (f(φ) + f(φ + π/2)) / √2
            wave = self.sum([wave, self.waves_of(kind, whole, int(eighths) // 2 + 1)], node)
            wave = Parsed(replace(wave.form, f=wave.form.f / 2), 1)
        return wave

    def not_exact(self, angle: Angle, node: Node) -> OptionError:
        """The error for an angle with a decimal in it that is no quarter turn."""
        shifted = [j for j in angle if PI < j <= len(self.shifts) and self.shifts[j - 1]]
        if shifted:
            names = ", ".join(f"θ{j} = q{j} {'−' if self.shifts[j - 1] < 0 else '+'} {abs(self.shifts[j - 1]):.6g} rad"
                              for j in shifted)  # fmt: skip
            return wrong(
                self.text, node.place, "sines and cosines of this angle are not exact",
                allowed=f"θ in place of q, with {names}", mend="write θ, or add the shift to q",
            )  # fmt: skip
        return wrong(
            self.text, node.place, "this angle is not exact",
            allowed="whole and half angles, plus quarter turns (pi/2)",
        )  # fmt: skip

    def waves_of(self, kind: str, turns: dict[int, int], quarters: int) -> Parsed:
        """sin or cos of Σ turns_j θ_j / 2 plus quarter turns."""
        kinds = ("cos", "sin")  # cos, −sin, −cos, sin as the angle grows by quarter turns
        steps = (quarters + (3 if kind == "sin" else 0)) % 4
        sign, wave_of_turns = wave(kinds[steps % 2], turns)
        sign = -sign if steps in (1, 2) else sign
        form = Product(Fraction(sign), () if wave_of_turns is None else ((wave_of_turns, 1),))
        return Parsed(half_of(form, self.ring))

    # values

    def value(self, node: Node) -> Parsed:
        """The tree as a function on the torus."""
        if node.kind == "number":
            return self.number(number_of(node.number, self.ring))
        if node.kind == "name":
            return self.symbol_of(node)
        if node.kind in ("sin", "cos"):
            return self.wave(node.kind, self.angle(node.parts[0]), node)
        if node.kind == "/":
            return self.inverse(node)
        if node.kind == "-":
            return self.negative(self.value(node.parts[0]))
        if node.kind == "+":
            return self.sum([self.value(part) for part in node.parts], node)
        if node.kind == "*":
            return self.product([(self.value(part), part) for part in node.parts])
        if node.kind == "**":
            return self.product([(self.value(node.parts[0]), node)] * int(node.number))
        raise wrong(self.text, node.place, "± stands before values of an angle only", allowed="θ4 = ±π/2")

    def inverse(self, node: Node) -> Parsed:
        """1 / a number."""
        divisor = self.value(node.parts[0])
        form = divisor.form
        if divisor.root or any(form.degrees) or form.f == 0 or form.f.total_degree() > 0:
            raise wrong(self.text, node.place, "a condition is divided by numbers only, not by 0")
        return self.number(1 / form.f.coeffs()[0] * self.ring.half.constant(1))

    def wave_of_sum(self, name: str) -> Wave | None:
        """The sine or cosine that a name like s23 stands for; None for another name, or joints that do not turn."""
        match = re.fullmatch(r"([sc])([1-9]+)", name)
        if match is None:
            return None
        joints = sorted(int(digit) for digit in match[2])
        if len(set(joints)) < len(joints) or not set(joints) <= set(self.ring.revolute):
            return None
        return Wave("sin" if match[1] == "s" else "cos", tuple((j, 2) for j in joints))

    def symbol_of(self, node: Node) -> Parsed:
        """A length, the variable of a slide, or s23."""
        ring, name = self.ring, node.name
        if name in ring.letters:
            return self.number(ring.letter_half[name])
        joint = self.joint(node)
        if joint is not None and joint in ring.prismatic:
            return self.number(ring.q_half[joint])
        of_sum = self.wave_of_sum(name)
        if of_sum is not None:
            return Parsed(half_of(Product(Fraction(1), ((of_sum, 1),)), ring))
        if joint is not None:
            raise wrong(self.text, node.place, "an angle stands inside sin or cos, or alone in an equation of angles")
        allowed = [*ring.letters, *(f"q{j}" for j in ring.prismatic)]
        if ring.revolute:
            allowed += [f"sin and cos of {self.angles()}", "s23 for sin(θ2 + θ3)"]
        if ring.letters:
            lengths = None
        else:
            lengths = "the lengths of this arm are numbers here: write numbers"
        raise wrong(self.text, node.place, f"{name[:40]!r} is not known", allowed=", ".join(allowed), mend=lengths)

    def joint(self, node: Node) -> int | None:
        """Number of the joint that a name speaks of; None for another name."""
        if node.name in self.ring.letters:
            return None
        match = re.fullmatch(r"(q|θ|theta|th)_?(\d{1,3})", node.name)
        if match is None:
            return None
        joint = int(match[2])
        if joint not in self.ring.revolute and joint not in self.ring.prismatic:
            known = ", ".join(f"q{j}" for j in sorted([*self.ring.revolute, *self.ring.prismatic]))
            raise wrong(self.text, node.place, f"there is no joint {joint}", allowed=known)
        return joint

    def negative(self, value: Parsed) -> Parsed:
        """−f."""
        return Parsed(replace(value.form, f=-value.form.f), value.root)

    def number(self, f: Polynomial) -> Parsed:
        """What does not depend on an angle."""
        return Parsed(Form(self.ring, f, (0,) * self.ring.angles))

    def product(self, factors: Iterable[tuple[Parsed, Node]]) -> Parsed:
        """Π f; √2 · √2 is 2. A factor that makes it too long is shown in the error."""
        total = self.number(self.ring.half.constant(1))
        for factor, node in factors:
            f, g = total.form.f, factor.form.f
            if len(f) * len(g) > LARGEST:
                raise wrong(
                    self.text, node.place, "multiplied out the condition has too many terms",
                    allowed=f"up to {LARGEST}",
                )  # fmt: skip
            degrees = tuple(map(add, total.form.degrees, factor.form.degrees))
            if max(degrees, default=0) > HIGH:
                raise wrong(
                    self.text, node.place, "the condition has too high powers of one angle's sine and cosine",
                    allowed=f"up to {HIGH // 2}",
                )  # fmt: skip
            root = total.root + factor.root
            total = Parsed(Form(self.ring, f * g * (2 if root == 2 else 1), degrees), root % 2)
        return total

    def sum(self, values: list[Parsed], node: Node) -> Parsed:
        """Σ f, over common degrees."""
        kept = [value for value in values if value.form.f != 0] or values[:1]
        if len({value.root for value in kept}) > 1:
            raise wrong(
                self.text, node.place, "terms with an eighth turn (pi/4) and terms without do not add up exactly",
            )  # fmt: skip
        try:
            form = add_forms([value.form for value in kept])
        except ValueError as error:
            raise wrong(self.text, node.place, f"{error}: the sign would depend on full turns") from error
        return Parsed(form, kept[0].root)


def _both_signs(node: Node) -> list[Node]:
    """±x as x and −x."""
    if node.kind == "±":
        return [node.parts[0], Node("-", node.place, (node.parts[0],))]
    if node.kind == "*" and node.parts[0].kind == "±":
        first = node.parts[0].parts[0]
        plus = Node("*", node.place, (first, *node.parts[1:]))
        return [plus, Node("-", node.place, (plus,))]
    return [node]


def parse_conditions(text: str, ring: Ring, *, shifts: Sequence[float] | None = None) -> tuple[Parsed, ...]:
    """The conditions of a text, all of which are to hold: separated by ";", "," or "and".

    Sums, products and whole powers of numbers, lengths, variables of slides, sin and cos of whole and half
    combinations of joint angles plus quarter turns, written as people do: sin(q2 + q3), s23, cos(θ4/2), π/2, 2θ3,
    a2 c2. "left = right" means that the difference is zero. Angles may stand for themselves on both sides, modulo 2π:
    θ4 = 0 or π, θ5 = θ3 + π.

    Args:
        text: as above.
        ring: its joints and lengths may be named.
        shifts: θ_j = q_j + shifts[j − 1] [rad]; None for none.

    Returns:
        One per condition.

    Raises:
        OptionError: a mistake in the text, with its place; or a condition that is no polynomial, or has no sign.

    Example:
        >>> ring = Ring([3, 5])
        >>> [atom.key for atom in parse_conditions("θ5 = θ3 + π; sin(q3) = 0", ring)[1].atoms]
        ['θ3=pi', 'θ3=0']
    """
    meaning = Meaning(text, ring, shifts)
    statements = read(text, frozenset(ring.letters))
    return tuple(replace(meaning.statement(statement), text=statement.name) for statement in statements)
