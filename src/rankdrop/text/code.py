"""Families as code: a Python module on NumPy, a C99 header, a LaTeX table."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from keyword import iskeyword
from math import pi
from textwrap import indent
from typing import TYPE_CHECKING

from rankdrop.algebra.polynomial import Polynomial
from rankdrop.errors import OptionError
from rankdrop.families.record import Family, exact_of
from rankdrop.formula.notation import C, Latex, Python, latex_name
from rankdrop.formula.sums import functions_of, joints_of
from rankdrop.formula.writing import AnglePin, Condition
from rankdrop.lists import flat_map
from rankdrop.text.latex import as_text

if TYPE_CHECKING:
    from rankdrop.exact.determinants import Minor

TAKEN = frozenset({"q", "np", "sin", "cos", "pi", "FAMILIES"})
"""Names that the Python module uses itself."""

_TITLE = "Singularities of {}: one function per family, derived exactly by rankdrop."
_PYTHON = '''"""{title}

{explained}
"""

import numpy as np
{imports}

{functions}

FAMILIES = {{
{families}}}
"""The functions by the marks of their families."""

NAMES = {{
{names}}}
"""What the families are called."""
'''
_PYTHON_MINORS = '''
DETERMINANTS = {{
{}}}
"""The determinant or minors of the Jacobian."""
'''
_PYTHON_FUNCTION = '''"""{said}

Args:
    q: (..., {n}) joint variables [rad, slides m].
{lengths}
Returns:
    {returns}
"""
q = np.asarray(q, dtype=float)
{joints}{body}
'''
_RESIDUALS = """return np.stack(
    [
        {},
    ],
    axis=-1,
)"""
_C_LENGTH = """#ifndef {macro}
#define {macro} ({value!r}) /* {meaning} [m] */
#endif
"""
_C_FAMILY = """
/* {name}, corank {corank}.
{conditions}
 * q [rad, slides m]; every residual is zero exactly on the family. */
#define {macro}_NAME "{plain}"
static inline void {mark}(const double q[{n}], double residual[{m}])
{{
{residuals}
}}

/* Derivatives of the residuals by q. */
static inline void {mark}_gradient(const double q[{n}], double gradient[{m}][{n}])
{{
    int i, j;
{unused}    for (i = 0; i < {m}; ++i)
        for (j = 0; j < {n}; ++j) gradient[i][j] = 0.0;
{slopes}
}}

/* Distance in joint space [rad, slides divided by the length]: pinned joints exactly, other
 * conditions by one Newton step: right near the family, an estimate far from it. */
static inline double {mark}_distance(const double q[{n}])
{{
    double square = 0.0{way};
{distance}    return sqrt(square);
}}
"""
_C_NEWTON = """    double residual[{m}], gradient[{m}][{n}], most = 0.0;
    int i;
    {mark}(q, residual);
    {mark}_gradient(q, gradient);
    for (i = {first}; i < {m}; ++i) {{
        double size = 0.0, one;
{squares}
        one = size > 0.0 ? fabs(residual[i]) / sqrt(size) : residual[i] == 0.0 ? 0.0 : HUGE_VAL;
        most = fmax(most, one);
    }}
    square += most * most;
"""
_C_MINOR = """
/* {name} of the Jacobian. q [rad, slides m]. */
static inline double {mark}(const double q[{n}])
{{
{unused}    return {value};
}}
"""
_UNUSED = "    (void)q;\n"
_LONG_CELL, _LONG_TABLE = 700, 24
"""Characters of the conditions of a family that fit a cell of a LaTeX table; rows of a table that fits a page."""


@dataclass(frozen=True)
class Code:
    """Families of one arm, to be written as code.

    Attributes:
        robot: name of the arm.
        n: number of joints.
        families: derived exactly, at least one condition each.
        letters: value of each length that is a symbol [m].
        shifts: θ_j = q_j + shifts[j − 1] [rad]; empty for none.
        determinants: to be written, too.

    Raises:
        OptionError: a family without a condition, or two families whose marks differ in punctuation alone.
    """

    robot: str
    n: int
    families: Sequence[Family]
    letters: Mapping[str, float]
    shifts: Sequence[float] = ()
    determinants: Sequence[Minor] = ()

    def __post_init__(self) -> None:
        for family in self.families:
            if not exact_of(family).stated:
                raise OptionError("a family without a condition has no residual", where=f"family {family.id}")
        marks = [_function(family.id) for family in self.families]
        if len(set(marks)) < len(marks):
            raise OptionError("two families have the same name in code", got=", ".join(sorted(marks)))

    def python(self) -> str:
        """A Python module: one function per family, q (..., n) -> residuals (..., m), lengths as keyword arguments."""
        functions = [*map(self._python_family, self.families), *map(self._python_minor, self.determinants)]
        forms = [condition.form for condition in flat_map(_conditions_of, self.families)]
        needed = functions_of([*forms, *(minor.value.form for minor in self.determinants)])
        minors = "".join(f'    "{minor.mark}": {minor.mark},\n' for minor in self.determinants)
        return _PYTHON.format(
            title=_TITLE.format(_plain(self.robot)), explained="\n".join(self._explanation_lines()),
            imports=f"from numpy import {', '.join(needed)}\n" * bool(needed), functions="\n\n".join(functions),
            families="".join(f'    "{family.id}": {_function(family.id)},\n' for family in self.families),
            names="".join(f'    "{family.id}": "{_plain(family.name)}",\n' for family in self.families),
        ) + (_PYTHON_MINORS.format(minors) if minors else "")  # fmt: skip

    def _python_family(self, family: Family) -> str:
        stated = _conditions_of(family)
        residuals = [condition.code(self._python_notation) for condition in stated]
        said = [f"{_plain(family.name)}, corank {family.corank}.", "", *(condition.text() for condition in stated)]
        return self._python_function(
            _function(family.id), "\n".join(said), [condition.polynomial for condition in exact_of(family).polynomials],
            f"(..., {len(residuals)}) residuals, all zero exactly on the family.",
            set(flat_map(lambda condition: condition.joints, stated)),
            _RESIDUALS.format(",\n        ".join(residuals)),
        )  # fmt: skip

    def _python_minor(self, minor: Minor) -> str:
        text = minor.value.code(self._python_notation)
        return self._python_function(
            minor.mark, f"{_plain(minor.name)} of the Jacobian.", [minor.value.polynomial], "(...) its value.",
            joints_of(minor.value.form),
            f"return {text} + np.zeros(q.shape[:-1])",
        )  # fmt: skip

    @property
    def _python_notation(self) -> Python:
        names = {name: name + "_" for name in self.letters if iskeyword(name) or name in TAKEN}
        return Python(shifts=self.shifts, names=names)

    def _python_function(
        self, name: str, said: str, polynomials: Sequence[Polynomial], returns: str, joints: set[int], body: str
    ) -> str:
        """A function of q and of the lengths that occur, with what is said of it, and what it returns."""
        used = {name for f in polynomials for name, d in zip(f.context().names(), f.degrees(), strict=True) if d > 0}
        names = self._python_notation.names
        lengths = {names.get(letter, letter): float(value) for letter, value in self.letters.items() if letter in used}
        keywords = ", *" * bool(lengths) + "".join(f", {letter}={value!r}" for letter, value in lengths.items())
        inside = _PYTHON_FUNCTION.format(
            said=said, n=self.n, returns=returns, body=body,
            lengths=f"    {', '.join(lengths)}: lengths [m].\n" * bool(lengths),
            joints="".join(f"q{j} = q[..., {j - 1}]\n" for j in sorted(joints)),
        )  # fmt: skip
        return f"def {name}(q{keywords}):\n" + indent(inside, "    ")

    def c(self) -> str:
        """A C99 header: per family its name and inline functions of q: residuals, their gradients, and the distance.

        Lengths are macros that can be defined before.
        """
        mark = f"rankdrop_{_mark(self.robot)}"
        guard = mark.upper()
        lengths = [(name, float(value), name) for name, value in self.letters.items()]
        if self._slides:
            lengths.append(("LENGTH", 1.0, "slides are divided by it in distances"))
        macros = (_C_LENGTH.format(macro=f"{guard}_{name}", value=value, meaning=what) for name, value, what in lengths)
        notation = C(shifts=self.shifts, names={name: f"{guard}_{name}" for name in self.letters})
        said = "\n * ".join(map(_comment, (_TITLE.format(_comment(self.robot)), *self._explanation_lines())))
        return "".join([
            f"/* {said}\n */\n#ifndef {guard}_H\n#define {guard}_H\n\n#include <math.h>\n\n", *macros,
            *(self._c_family(family, f"{mark}_{_mark(family.id)}", notation) for family in self.families),
            *(self._c_minor(minor, f"{mark}_{minor.mark}", notation) for minor in self.determinants), "\n#endif\n",
        ])  # fmt: skip

    def _c_family(self, family: Family, mark: str, notation: C) -> str:
        stated = _conditions_of(family)
        slopes = [
            f"    gradient[{i}][{j - 1}] = {text};"
            for i, condition in enumerate(stated) for j, text in condition.gradient(notation).items()
        ]  # fmt: skip
        return _C_FAMILY.format(
            name=_comment(family.name), corank=family.corank, plain=_plain(family.name), mark=mark, macro=mark.upper(),
            conditions="\n".join(f" * {_comment(condition.text())}" for condition in stated), n=self.n, m=len(stated),
            residuals="\n".join(
                f"    residual[{i}] = {condition.code(notation)};" for i, condition in enumerate(stated)
            ),
            unused="" if any("q[" in line for line in slopes) else _UNUSED, slopes="\n".join(slopes),
            way=", way" * bool(exact_of(family).pins), distance=self._c_distance(family, mark),
        )  # fmt: skip

    def _c_distance(self, family: Family, mark: str) -> str:
        """Pinned joints to their nearest values, exactly; of the other conditions the largest |f|/|∇f|."""
        body, exact = "", exact_of(family)
        for pin in exact.pins:
            if len(self.shifts):
                shift = self.shifts[pin.joint - 1]
            else:
                shift = 0.0
            period = 2 * pi * pin.part
            for place, angle in enumerate(pin.angles):
                gap = f"fabs(remainder(q[{pin.joint - 1}] - ({float(pin.part * angle - shift)!r}), {period!r}))"
                body += f"    way = {gap if place == 0 else f'fmin(way, {gap})'};\n"
            body += "    square += way * way;\n"
        if not exact.polynomials:
            return body
        scale = f" * {mark.upper().removesuffix(f'_{_mark(family.id).upper()}')}_LENGTH"
        squares = "\n".join(
            f"        size += gradient[i][{j - 1}] * gradient[i][{j - 1}]{scale * 2 * (j in self._slides)};"
            for j in range(1, self.n + 1)
        )
        return body + _C_NEWTON.format(
            m=len(exact.stated), n=self.n, mark=mark, first=len(exact.pins), squares=squares
        )

    def _c_minor(self, minor: Minor, mark: str, notation: C) -> str:
        value = minor.value.code(notation)
        unused = "" if joints_of(minor.value.form) else _UNUSED
        return _C_MINOR.format(name=_comment(minor.name), mark=mark, n=self.n, unused=unused, value=value)

    @property
    def _slides(self) -> frozenset[int]:
        slides: set[int] = set()
        for family in self.families:
            for condition in exact_of(family).polynomials:
                slides.update(condition.ring.prismatic)
        return frozenset(slides)

    def latex(self) -> str:
        """A table: mark, name, corank, conditions; below it the lengths, shifted angles and what s and c stand for.

        Conditions that are long stand below the table, where pages break; a table that is long breaks over pages.
        """
        rows, long = self._latex_rows()
        values = [rf"${_latex_minor(minor)} = {minor.value.latex()}$" for minor in self.determinants]
        formulas = [*rows, *long, *values]
        packages = []
        if len(rows) > _LONG_TABLE or long:
            kind = "longtable"
            packages.append(kind)
        else:
            kind = "tabular"
        if any(r"\tfrac" in formula for formula in formulas):
            packages.append("amsmath")
        lines = []
        if packages:
            lines.append(rf"% needs \usepackage{{{','.join(packages)}}}")
        lines += [
            rf"\begin{{{kind}}}{{@{{}}l@{{\quad}}p{{0.24\linewidth}}@{{\ }}r@{{\quad}}p{{0.48\linewidth}}@{{}}}}",
            r"& family & corank & conditions \\", r"\hline", *rows, rf"\end{{{kind}}}",
        ]  # fmt: skip
        if long:
            lines += [r"{\small\raggedright\sloppy", *long, "}"]
        for value in values:
            lines += [r"\par\smallskip", value]
        meanings = self._latex_meanings(formulas)
        if meanings:
            lines += [r"\par\smallskip", ", ".join(f"${text}$" for text in meanings)]
        return "\n".join([*lines, ""])

    def _latex_meanings(self, formulas: Iterable[str]) -> list[str]:
        """The lengths, the angles that are shifted, and, where the formulas have them, what s and c stand for."""
        meanings = [rf"{latex_name(name)} = {float(value):.12g}\,\mathrm{{m}}" for name, value in self.letters.items()]
        meanings += [rf"\theta_{{{j}}} = q_{{{j}}} {_shift_latex(shift)}" for j, shift in self._joint_shifts()]
        if any(re.search(r"\b[sc]_", formula) for formula in formulas):
            meanings += [r"s_i = \sin\theta_i", r"c_{ij} = \cos(\theta_i + \theta_j)"]
        return meanings

    def _latex_rows(self) -> tuple[list[str], list[str]]:
        """(rows of the table, conditions that are too long for it)."""
        rows: list[str] = []
        long: list[str] = []
        for family in self.families:
            formulas = [f"${condition.latex()}$" for condition in _conditions_of(family)]
            if sum(map(len, formulas)) > _LONG_CELL:
                long.append(rf"\par\smallskip\noindent {family.id}: {'; '.join(formulas)}\par")
                formulas = ["see below"]
            shown = r"; \newline ".join(formulas)
            cells = (family.id, rf"\raggedright {as_text(family.name)}", str(family.corank), rf"\raggedright {shown}")
            rows.append(" & ".join(cells) + r" \tabularnewline")
        return rows, long

    def _joint_shifts(self) -> Iterator[tuple[int, float]]:
        yield from ((j, float(shift)) for j, shift in enumerate(self.shifts, 1) if shift)

    def _explanation_lines(self) -> list[str]:
        lines = [
            f"q1 to q{self.n} are joint variables in rad, those of slides in m; lengths are in m.",
            "A configuration lies on a family where all residuals are zero. s_i = sin θi, c_ij = cos(θi + θj).",
        ]
        shifted = [f"θ{j} = q{j} {'−' if s < 0 else '+'} {abs(s):.12g} rad" for j, s in self._joint_shifts()]
        if shifted:
            return [*lines, f"In the words on a condition {', '.join(shifted)}."]
        return lines


def _conditions_of(family: Family) -> tuple[AnglePin | Condition, ...]:
    """Every condition of a derived family, those of pinned joints first."""
    exact = exact_of(family)
    return (*exact.pins, *exact.polynomials)


def _shift_latex(shift: float) -> str:
    value = Latex().angle_value(abs(shift))
    if shift < 0:
        return f"- {value}"
    return f"+ {value}"


def _mark(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_").lower() or "arm"


def _function(text: str) -> str:
    """A mark as a Python name."""
    mark = _mark(text)
    if mark[0].isdigit() or iskeyword(mark) or mark in TAKEN:
        return f"family_{mark}"
    return mark


def _plain(text: str) -> str:
    return " ".join(text.replace("\\", "/").replace('"', "'").split())


def _comment(text: str) -> str:
    return " ".join(text.replace("*/", "* /").replace("/*", "/ *").replace("\\", "/").replace("??", "? ?").split())


def _latex_minor(minor: Minor) -> str:
    r"""det J11 → \det J_{11}, |$1 $2| → |\$_1 \, \$_2|, |vx wz| → |v_x \, w_z|."""
    if not minor.entries:
        return rf"\det {latex_name(minor.matrix)}"
    escaped = {"$": r"\$"}
    words = [f"{escaped.get(letter, letter)}_{index}" for letter, index in minor.entries]
    return "|" + r" \, ".join(words) + "|"
