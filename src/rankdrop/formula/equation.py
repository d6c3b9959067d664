"""Equations of families: trigonometric polynomials in the joint variables, alone and as systems that are solved.

An equation is f(q) = Σ c · sin|cos(m·q − s) · Π q_j^p. Revolute joints enter through the harmonics m, prismatic ones
through the powers p. m may hold half-integers: sin((θ3 + θ5)/2) is the linear relation θ3 + θ5 = 0. Such an f is
defined on the torus up to its sign when, joint by joint, all terms have the same parity of 2m, and its zero set is
then well defined (`Equation.parity`).

A `System` is several equations at once: values, Jacobian, solutions from any start, and the distance to the common zero
set.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.robot.model import Array
from rankdrop.solve import CUT

_PARTS = 144  # largest denominator of a harmonic
_UNSEEN = 1e-10  # terms below this share of the largest are not written for people: fits leave them, as rounding

_Style = dict[str, str]
"""How formulas are written: joint and slide, function, minus, π and 1; powers as superscripts, or raised."""
_PLAIN = {
    "angle": "θ{}", "slide": "q{}", "function": "{} ", "minus": "−", "pi": "π", "digits": "⁰¹²³⁴⁵⁶⁷⁸⁹", "power": "{}",
    "one": "1", "times": " ", "multiple": "",
}  # fmt: skip
_LATEX = _PLAIN | {
    "angle": r"\theta_{{{}}}", "slide": "q_{{{}}}", "function": "\\{} ", "minus": "-", "pi": r"\pi",
    "digits": "0123456789", "power": "^{{{}}}",
}  # fmt: skip
_PYTHON = {
    "angle": "q{}", "slide": "q{}", "function": "{}", "minus": "-", "pi": "pi", "digits": "0123456789",
    "power": "**{}", "one": "1.0", "times": "*", "multiple": "*",
}  # fmt: skip

Mask = NDArray[np.bool_]

CLOSE = 1e-8  # steps shorter than this add nothing to a distance [rad]
REACHED = 1e-9  # |f| at a foot: long fitted equations agree with each other to 1e-11
SOLVED = 1e-12  # |f| of a solution, the equations having coefficients of size one

_DEPENDENT = 1e-14  # share of the largest singular value below which gradients are dependent by rounding alone
_NOTHING = 1e-15  # |f| that no step can better
_NEAR = 1e-11  # |f|/|∇f| of a zero that Newton has come to rest at [rad]
_ROUNDING = 1e-15  # |f| of a zero whose derivative vanishes, for coefficients that add up to 1


@dataclass(frozen=True, slots=True)
class Term:
    """c · sin|cos(½·Σ harmonics_j q_j − shift) · Π q_j^powers_j.

    Attributes:
        coefficient: c.
        kind: "sin" or "cos".
        harmonics: (n,) twice the multiples m, so that they are whole numbers; fractions where another joint turns by a
            fraction of the angle.
        powers: (n,) exponents of prismatic joints.
        shift: phase s [rad].
    """

    coefficient: float
    kind: str
    harmonics: tuple[int | Fraction, ...]
    powers: tuple[int, ...]
    shift: float = 0.0

    @property
    def divided(self) -> bool:
        """Whether a harmonic is no whole number."""
        return any(isinstance(h, Fraction) for h in self.harmonics)


@dataclass(frozen=True)
class Equation:
    """One condition f(q) = 0.

    Attributes:
        terms: summands, in the order they are printed.

    Raises:
        OptionError: no term, an unknown kind, or terms of different lengths.
    """

    terms: tuple[Term, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "terms", tuple(self.terms))
        if not self.terms:
            raise OptionError("an equation needs at least one term")
        lengths = {len(term.harmonics) for term in self.terms} | {len(term.powers) for term in self.terms}
        if len(lengths) != 1:
            raise OptionError("the terms of an equation have different numbers of joints", got=sorted(lengths))
        kinds = {term.kind for term in self.terms} - {"sin", "cos"}
        if kinds:
            raise OptionError("unknown kind of term", got=", ".join(sorted(kinds)), allowed="sin, cos")

    def __reduce__(self) -> tuple[type[Equation], tuple[tuple[Term, ...]]]:
        return Equation, (self.terms,)  # what the core keeps is made anew in another process

    @property
    def n(self) -> int:
        """Number of joint variables."""
        return len(self.terms[0].harmonics)

    @cached_property
    def tables(self) -> tuple[Array, Array, Array, Array, Array]:
        """f = Σ (a cos φ + b sin φ) · Π q_j^p_j with φ = m·q − shift, one summand per row.

        Returns:
            (t, n) multiples m, (t,) shifts [rad], (t,) a, (t,) b, (t, n) powers p.
        """
        waves: dict[tuple[tuple[int | Fraction, ...], tuple[int, ...], float], list[float]] = {}
        for term in self.terms:
            pair = waves.setdefault((term.harmonics, term.powers, term.shift), [0.0, 0.0])
            pair[term.kind == "sin"] += term.coefficient
        m = np.array([key[0] for key in waves], dtype=np.float64) / 2
        p = np.array([key[1] for key in waves], dtype=np.float64)
        shift = np.array([key[2] for key in waves])
        both = np.array(list(waves.values()))
        return m, shift, both[:, 0], both[:, 1], p

    @cached_property
    def compiled(self) -> _core.Families:
        """The equation as the core takes it."""
        return compiled((self,))

    @property
    def joints(self) -> tuple[int, ...]:
        """Numbers (from 1) of the joints that occur."""
        m, _, _, _, p = self.tables
        return tuple(int(j) + 1 for j in np.flatnonzero((np.abs(m) + p).sum(axis=0)))

    @property
    def parity(self) -> tuple[int, ...] | None:
        """(n,) 0 or 1 per joint: what q_j + 2π does to the sign of f; None when terms disagree, and for fractions."""
        kinds = {tuple(h % 2 for h in term.harmonics) for term in self.terms}
        if len(kinds) > 1 or any(term.divided for term in self.terms):
            return None
        return tuple(map(int, kinds.pop()))

    def __call__(self, q: ArrayLike) -> Array:
        """f(q).

        Args:
            q: (..., n) configurations [rad, m].

        Returns:
            (...,) values.

        Raises:
            ConfigurationError: q has another number of joints.
        """
        rows, batch = self._rows(q)
        return _core.equations(self.compiled, rows, slopes=False).reshape(batch)

    def gradient(self, q: ArrayLike) -> Array:
        """∂f/∂q: (..., n) at configurations q (..., n).

        Raises:
            ConfigurationError: q has another number of joints.
        """
        return self.with_gradient(q)[1]

    def with_gradient(self, q: ArrayLike) -> tuple[Array, Array]:
        """f (...,) and ∂f/∂q (..., n) at once.

        Raises:
            ConfigurationError: q has another number of joints.
        """
        rows, batch = self._rows(q)
        values, slopes = _core.equations(self.compiled, rows)
        return values.reshape(batch), slopes.reshape(*batch, self.n)

    def _rows(self, q: ArrayLike) -> tuple[Array, tuple[int, ...]]:
        q = np.asarray(q, dtype=np.float64)
        if q.ndim == 0 or q.shape[-1] != self.n:
            raise ConfigurationError("q has the wrong number of joints", got=q.shape, allowed=f"(..., {self.n})")
        return np.ascontiguousarray(q).reshape(-1, self.n), q.shape[:-1]

    def text(self) -> str:
        """f as a Python expression in q1 … qn, sin, cos and pi; exact to the last digit, for numbers and arrays."""
        return self._text

    __json__ = text

    @cached_property
    def _text(self) -> str:
        return _write_sum(self.terms, _PYTHON, repr)

    def pretty(self, digits: int = 4) -> str:
        """f for people: "0.9087 cos θ2 + cos(θ2+θ3)"; prismatic joints are written q_j. No "= 0".

        Terms smaller than `_UNSEEN` of the largest are left out; they stay in `terms`, where a double zero needs them.
        """
        return _write_sum(self._visible_terms, _PLAIN, lambda x: f"{x:.{digits}g}")

    def latex(self, digits: int = 4) -> str:
        r"""The same as mathematics of LaTeX: "0.9087 \cos \theta_{2} + \cos(\theta_{2}+\theta_{3})"."""
        return _write_sum(self._visible_terms, _LATEX, lambda x: f"{x:.{digits}g}")

    @property
    def _visible_terms(self) -> list[Term]:
        least = _UNSEEN * max(abs(term.coefficient) for term in self.terms)
        return [term for term in self.terms if abs(term.coefficient) > least]

    def __str__(self) -> str:
        return self._pretty

    @cached_property
    def _pretty(self) -> str:
        return self.pretty()

    def to_dict(self) -> dict[str, Any]:
        """Plain data: the text and the terms."""
        return {
            "text": self.text(),
            "terms": [
                {
                    "coefficient": term.coefficient,
                    "kind": term.kind,
                    "harmonics": [float(h / 2) for h in term.harmonics],
                    "powers": list(term.powers),
                    "shift": term.shift,
                }
                for term in self.terms
            ],
        }

    @classmethod
    def from_dict(cls, record: dict[str, Any]) -> Equation:
        """The equation of a record made by `to_dict`."""
        return cls(
            tuple(
                Term(
                    float(term["coefficient"]),
                    term["kind"],
                    tuple(map(_harmonic, term["harmonics"])),
                    tuple(int(p) for p in term["powers"]),
                    float(term["shift"]),
                )
                for term in record["terms"]
            )
        )


def _harmonic(multiple: float) -> int | Fraction:
    """Twice a multiple that a file holds as a decimal."""
    share = Fraction(2 * multiple).limit_denominator(_PARTS)
    if share.denominator == 1:
        return int(share)
    return share


def compiled(equations: Sequence[Equation]) -> _core.Families:
    """Equations as the core takes them, as one family without pins; there is at least one."""
    n = equations[0].n
    return _core.make_families(
        variables=n, **equation_tables(equations), equations=[0, len(equations)], corank=[1], scale=[1.0] * n,
        periodic=[0] * n, coupled=[1] * len(equations), pins=[0, 0], pinned=[], at=[0], values=[],
    )  # fmt: skip


def equation_tables(equations: Iterable[Equation]) -> dict[str, Any]:
    """Equations as flat lists by name, as `_core.make_families` takes them: angles and terms, each angle once."""
    numbers: dict[tuple[tuple[float, ...], float], int] = {}  # an angle, by its joints' multiples and its shift
    angle: list[int] = []
    a: list[float] = []
    b: list[float] = []
    powers: list[int] = []
    terms = [0]
    for equation in equations:
        multiples, shifts, cosine, sine, p = equation.tables
        for m, shift in zip(multiples.tolist(), shifts.tolist(), strict=True):
            angle.append(numbers.setdefault((tuple(m), shift), len(numbers)))
        a += cosine.tolist()
        b += sine.tolist()
        powers += p.reshape(-1).astype(int).tolist()
        terms.append(len(angle))
    turning = [[(j, x) for j, x in enumerate(m) if x] for m, _ in numbers]
    return {
        "shift": [shift for _, shift in numbers], "turns": np.cumsum([0, *map(len, turning)]).tolist(),
        "turning": [j for row in turning for j, _ in row], "m": [x for row in turning for _, x in row],
        "angle": angle, "a": a, "b": b, "powers": powers, "terms": terms,
    }  # fmt: skip


def normalised_equation(terms: Iterable[Term], threshold: float = 1e-15) -> Equation:
    """The equation divided by its largest coefficient, first sign positive, terms below `threshold` dropped."""
    kept = list(terms)
    largest = max((abs(term.coefficient) for term in kept), default=0.0)
    kept = [term for term in kept if abs(term.coefficient) > threshold * largest]
    if not kept:
        raise OptionError("an equation needs a term that is not zero")
    scale = float(np.copysign(largest, kept[0].coefficient))
    return Equation(tuple(Term(t.coefficient / scale, t.kind, t.harmonics, t.powers, t.shift) for t in kept))


def _write_sum(terms: Iterable[Term], style: _Style, number: Callable[[float], str]) -> str:
    """A sum in one of the styles; `number` writes what is not negative."""
    text = ""
    for term in terms:
        factors = _factors(term, style, number)
        size = number(abs(float(term.coefficient)))
        if term.coefficient < 0:
            sign = style["minus"]
        else:
            sign = "+"
        text += f" {sign} " if text else sign.strip("+")
        text += style["times"].join(factors if factors and size == style["one"] else [size, *factors])
    return text


def _factors(term: Term, style: _Style, number: Callable[[float], str]) -> list[str]:
    """What a coefficient is multiplied by: the wave, and powers of slides."""
    if any(term.harmonics) or term.shift:
        factors = [_wave(term, style, number)]
    else:
        factors = []
    if not factors and term.kind == "sin":
        factors.append("0.0")
    for j, power in enumerate(term.powers, start=1):
        if power:
            raised = style["power"].format(str(power).translate(str.maketrans("0123456789", style["digits"])))
            factors.append(style["slide"].format(j) + (raised if power > 1 else ""))
    return factors


def _wave(term: Term, style: _Style, number: Callable[[float], str]) -> str:
    """Sine or cosine of a term: "cos θ2", "sin(θ2+2θ3 − π/2)", "cos((θ3−θ5)/2)"."""
    halved, python = _in_half_angles(term), style is _PYTHON
    angles = _sum_of_angles(term, style)
    one_joint = sum(map(bool, term.harmonics)) == 1 and not term.shift
    bare = one_joint and (python or angles.startswith(style["angle"][0])) and not term.divided  # no minus, no multiple
    argument = angles + _phase(term, style, number)
    if halved:
        argument = f"{argument}/2" if bare else f"({argument})/2"
    name = style["function"].format(term.kind)
    if bare and not halved and not python:
        return f"{name}{argument}"
    return f"{name.strip()}({argument})"


def _in_half_angles(term: Term) -> bool:
    """Whether the argument of a term is written as half a sum of angles: a harmonic, in half angles, is odd."""
    return not term.divided and any(h % 2 for h in term.harmonics)


def _sum_of_angles(term: Term, style: _Style) -> str:
    """Angles of the joints with their multiples, "θ2+2θ3"; the sum that is halved, where it is."""
    unit = Fraction(1 if _in_half_angles(term) else 2)
    text = ""
    for j, h in enumerate(term.harmonics, start=1):
        if not h:
            continue
        if h < 0:
            text += style["minus"]
        elif text:
            text += "+"
        text += _multiple(abs(Fraction(h)) / unit, style["angle"].format(j), style)
    return text


def _multiple(multiple: Fraction, angle: str, style: _Style) -> str:
    """An angle times a positive number: "2θ3", "3θ2/2"."""
    text = angle
    if multiple.numerator > 1:
        text = f"{multiple.numerator}{style['multiple']}{angle}"
    if multiple.denominator > 1:
        text += f"/{multiple.denominator}"
    return text


def _phase(term: Term, style: _Style, number: Callable[[float], str]) -> str:
    """Phase that is taken from the sum of the angles, " − π/2"; "" where there is none."""
    if not term.shift:
        return ""
    shift = term.shift * (2 if _in_half_angles(term) else 1)
    sign = style["minus"] if shift > 0 else "+"
    if style is _PYTHON:
        return f"{sign}{abs(shift)!r}"
    return f" {sign} {_written_angle(abs(shift), number, style)}"


def pretty_angle(value: float, digits: int = 4) -> str:
    """An angle for people: multiples of π/12 as fractions of π ("−π/2", "2π/3"), anything else as a number [rad]."""
    return _written_angle(value, lambda x: f"{x:.{digits}g}", _PLAIN)


def share_of_pi(value: float) -> Fraction | None:
    """An angle in parts of π where it is a multiple of π/12, to 1e-9 of that; else None.

    Example:
        >>> share_of_pi(-pi / 2), share_of_pi(0.3)
        (Fraction(-1, 2), None)
    """
    twelfths = value * 12 / pi
    whole = round(twelfths)
    if abs(twelfths - whole) > 1e-9:
        return None
    return Fraction(whole, 12)


def _written_angle(value: float, number: Callable[[float], str], style: _Style) -> str:
    share = share_of_pi(value)
    if share is None:
        return number(value).replace("-", style["minus"])
    if share == 0:
        return "0"
    top, bottom = abs(share.numerator), share.denominator
    text = (style["pi"] if top == 1 else f"{top}{style['pi']}") + (f"/{bottom}" if bottom > 1 else "")
    return (style["minus"] if share < 0 else "") + text


@dataclass(frozen=True)
class System:
    """f_1(q) = … = f_e(q) = 0.

    Attributes:
        equations: the f_i; coefficients of size one.
    """

    equations: tuple[Equation, ...]

    def __reduce__(self) -> tuple[type[System], tuple[tuple[Equation, ...]]]:
        return System, (self.equations,)  # what the core keeps is made anew in another process

    @cached_property
    def compiled(self) -> _core.Families:
        """The equations as the core takes them; there is at least one."""
        return compiled(self.equations)

    @cached_property
    def moves(self) -> Mask:
        """(n,) joints that occur; there is at least one equation."""
        occurs = [(np.abs(m) + p).sum(axis=0) > 0 for m, _, _, _, p in (equation.tables for equation in self.equations)]
        moving = np.asarray(np.logical_or.reduce(occurs))
        moving.flags.writeable = False
        return moving

    def values(self, q: Array) -> Array:
        """(N, e) values at q (N, n)."""
        return _core.equations(self.compiled, np.ascontiguousarray(q, dtype=np.float64), slopes=False)

    def jacobian(self, q: Array) -> Array:
        """(N, e, n) derivatives at q (N, n)."""
        return self.linear(q)[1]

    def linear(self, q: Array) -> tuple[Array, Array]:
        """(N, e) values and (N, e, n) derivatives at once."""
        return _core.equations(self.compiled, np.ascontiguousarray(q, dtype=np.float64))

    def zero(self, q: Array) -> Mask:
        """(N,) whether every equation is zero at q (N, n), to rounding or to first order.

        Where its derivative all but vanishes too, a small value is none: near a place where an equation is zero to the
        fourth order it is below 1e-12 a thousandth of a radian away.
        """
        f, slope = self.linear(q)
        sizes = [sum(abs(term.coefficient) for term in equation.terms) for equation in self.equations]
        rounding = _ROUNDING * np.array(sizes)
        return np.asarray((np.abs(f) <= _NEAR * np.linalg.norm(slope, axis=-1) + rounding).all(axis=-1))

    def solve(
        self, q: Array, *, along: Array | None = None, iterations: int = 40, step: float = 0.5, still: float = 1e-14,
        cut: float = CUT,
    ) -> tuple[Array, Mask]:  # fmt: skip
        """Gauss–Newton with the shortest step −A⁺f, capped, from every start.

        Args:
            q: (N, n) starts.
            along: (n, d) orthonormal basis of the directions that may be used; None for all.
            iterations: at most.
            step: longest step [rad].
            still: a start whose step gets shorter has arrived [rad].
            cut: singular values of A below this share of the largest are not inverted.

        Returns:
            (N, n) end points and (N,) whether |f| ≤ 1e-12 there.
        """
        q = np.array(q, dtype=np.float64)
        if not self.equations or not len(q):
            return q, np.ones(len(q), dtype=np.bool_)
        if along is not None and not along.size:
            return q, np.abs(self.values(q)).max(axis=1) <= SOLVED
        if along is None:
            directions = []
        else:
            directions = along.ravel().tolist()
        settings = _core.ZeroSettings(
            iterations=iterations, step=step, still=still, enough=_NOTHING, cut=cut, along=directions
        )
        end, worst = _core.zeros(self.compiled, np.ascontiguousarray(q, dtype=np.float64), settings)
        return end, worst <= SOLVED

    def solve_flat(self, q: Array, *, along: Array, iterations: int) -> tuple[Array, Mask]:
        """`solve`; starts that rest where gradients are all but dependent go on with no singular value left out.

        Next to a special structure a root of several equations may lie where two of them have nearly one gradient.
        """
        q, solved = self.solve(q, along=along, iterations=iterations)
        resting = ~solved
        q[resting], solved[resting] = self.solve(q[resting], along=along, iterations=iterations, cut=_DEPENDENT)
        return q, solved

    def nearest(self, q: Array, within: float = 1e-3) -> tuple[Array, Array]:
        """Way from points to the zero set.

        |f|/|∇f| is wrong where ∇f vanishes (two sheets crossing), so the way is walked: Gauss–Newton to the end.

        Args:
            q: (N, n) points.
            within: longest way looked at [rad].

        Returns:
            (N,) length of the way [rad], inf where it is longer or does not get there, and (N, n) the foot.
        """
        length, foot = np.full(len(q), np.inf), np.array(q, dtype=np.float64)
        if not self.equations:
            return np.zeros(len(q)), foot
        near = np.flatnonzero(self._first_order(q) <= 4 * within)
        end, _ = self.solve(q[near], iterations=40, step=within, still=CLOSE)
        there = np.abs(self.values(end)).max(axis=1) <= REACHED
        way = np.linalg.norm(end - q[near], axis=1)
        length[near] = np.where(there & (way <= within), way, np.inf)
        foot[near] = end
        return length, foot

    def _first_order(self, q: Array) -> Array:
        """Largest |f_i|/|∇f_i|, with |f|^½ where the gradient is small: never far above the distance."""
        f, slope = self.linear(q)
        f, slope = np.abs(f), np.linalg.norm(slope, axis=-1)
        return np.asarray(np.minimum(f / np.maximum(slope, 1e-300), np.sqrt(f)).max(axis=1))
