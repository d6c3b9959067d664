"""Families as code: a Python module on NumPy, a C99 header, a LaTeX table."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from keyword import iskeyword
from math import pi
from typing import TYPE_CHECKING

from rankdrop.errors import OptionError
from rankdrop.exact.algebra.polynomial import Polynomial
from rankdrop.exact.notation import C, Python, latex_angle, latex_name

if TYPE_CHECKING:
    from rankdrop.exact.determinants import Minor
    from rankdrop.exact.family import ExactFamily

TAKEN = frozenset({"q", "np", "sin", "cos", "pi", "FAMILIES"})
"""Names that the Python module uses itself."""


@dataclass(frozen=True)
class Code:
    """Families of one arm, to be written as code.

    Attributes:
        robot: name of the arm.
        n: number of joints.
        families: at least one condition each.
        letters: value of each length that is a symbol [m].
        shifts: θ_j = q_j + shifts[j − 1] [rad]; empty for none.
        determinants: to be written, too.

    Raises:
        OptionError: a family without a condition, or two families whose marks differ in punctuation alone.
    """

    robot: str
    n: int
    families: Sequence[ExactFamily]
    letters: Mapping[str, float]
    shifts: Sequence[float] = ()
    determinants: Sequence[Minor] = ()

    def __post_init__(self) -> None:
        for family in self.families:
            if not family.pins and not family.conditions:
                raise OptionError("a family without a condition has no residual", where=f"family {family.id}")
        marks = [_function(family.id) for family in self.families]
        if len(set(marks)) < len(marks):
            raise OptionError("two families have the same name in code", got=", ".join(sorted(marks)))

    def python(self) -> str:
        """A Python module: one function per family, q (..., n) -> residuals (..., m), lengths as keyword arguments."""
        head = [f"Singularities of {_plain(self.robot)}: one function per family, derived exactly by rankdrop.", ""]
        head += [f"{line}" for line in self._explained()]
        functions = [self._python_function(family) for family in self.families]
        functions += [self._python_determinant(one) for one in self.determinants]
        needed = [name for name in ("cos", "pi", "sin") if any(re.search(rf"\b{name}\b", f) for f in functions)]
        imports = "import numpy as np\n" + (f"from numpy import {', '.join(needed)}\n" if needed else "")
        entries = "".join(f'    "{family.id}": {_function(family.id)},\n' for family in self.families)
        table = f'FAMILIES = {{\n{entries}}}\n"""The functions by the marks of their families."""\n'
        said = "".join(f'    "{family.id}": "{_plain(family.name)}",\n' for family in self.families)
        table += f'\nNAMES = {{\n{said}}}\n"""What the families are called."""\n'
        if self.determinants:
            entries = "".join(f'    "{one.mark}": {one.mark},\n' for one in self.determinants)
            table += f'\nDETERMINANTS = {{\n{entries}}}\n"""The determinant or minors of the Jacobian."""\n'
        return "\n\n".join(['"""' + "\n".join(head) + f'\n"""\n\n{imports}', *functions, table])

    def _python_function(self, family: ExactFamily) -> str:
        residuals = [one.code(self._python_notation) for one in family.stated]
        body = ["    return np.stack(", "        [", *(f"            {text}," for text in residuals), "        ],"]
        said = [f"{_plain(family.name)}, corank {family.corank}.", "", *(one.text() for one in family.stated)]
        returns = f"(..., {len(residuals)}) residuals, all zero exactly on the family."
        joints = sorted({joint for one in family.stated for joint in one.joints})
        body += ["        axis=-1,", "    )"]
        lengths = self._in(*(condition.polynomial for condition in family.conditions))
        return self._python_definition(_function(family.id), said, lengths, returns, joints, body)

    def _python_determinant(self, minor: Minor) -> str:
        text = minor.value.code(self._python_notation)
        joints = [j for j in range(1, self.n + 1) if re.search(rf"\bq{j}\b", text)]
        said, lengths = [f"{_plain(minor.name)} of the Jacobian."], self._in(minor.value.polynomial)
        body = [f"    return {text} + np.zeros(q.shape[:-1])"]
        return self._python_definition(minor.mark, said, lengths, "(...) its value.", joints, body)

    @property
    def _python_notation(self) -> Python:
        names = {name: name + "_" for name in self.letters if iskeyword(name) or name in TAKEN}
        return Python(shifts=self.shifts, names=names)

    def _python_definition(
        self, name: str, said: list[str], lengths: list[str], returns: str, joints: list[int], body: list[str]
    ) -> str:
        """A function of q and of lengths, with what is said of it, and what it returns."""
        names = self._python_notation.names
        used = {names.get(length, length): float(self.letters[length]) for length in lengths}
        keywords = "".join(f", {length}={value!r}" for length, value in used.items())
        lines = [f"def {name}(q{', *' if used else ''}{keywords}):", f'    """{said[0]}']
        lines += [f"    {line}" if line else "" for line in (*said[1:], "", "Args:")]
        lines += [f"        q: (..., {self.n}) joint variables [rad, slides m]."]
        lines += [f"        {', '.join(used)}: lengths [m]."] if used else []
        lines += ["", "    Returns:", f"        {returns}", '    """', "    q = np.asarray(q, dtype=float)"]
        return "\n".join([*lines, *(f"    q{j} = q[..., {j - 1}]" for j in joints), *body]) + "\n"

    def c(self) -> str:
        """A C99 header: per family its name and inline functions of q: residuals, their gradients, and the distance.

        Lengths are macros that can be defined before.
        """
        mark = _mark(self.robot)
        prefix = f"RANKDROP_{mark.upper()}"
        lines = [f"/* Singularities of {_comment(self.robot)}: one function per family, derived exactly by rankdrop."]
        lines += [f" * {_comment(line)}" for line in self._explained()]
        lines += [" */", f"#ifndef {prefix}_H", f"#define {prefix}_H", "", "#include <math.h>", ""]
        for name, value in self.letters.items():
            macro = f"{prefix}_{name}"
            lines += [f"#ifndef {macro}", f"#define {macro} ({float(value)!r}) /* {name} [m] */", "#endif"]
        if self._slides:
            macro = f"{prefix}_LENGTH"
            lines += [f"#ifndef {macro}", f"#define {macro} (1.0) /* slides are divided by it in distances [m] */"]
            lines += ["#endif"]
        notation = C(shifts=self.shifts, names={name: f"{prefix}_{name}" for name in self.letters})
        for family in self.families:
            lines += ["", *self._c_function(family, f"rankdrop_{mark}", notation)]
            lines += ["", *self._c_gradient(family, f"rankdrop_{mark}", notation)]
            lines += ["", *self._c_distance(family, f"rankdrop_{mark}")]
        for one in self.determinants:
            text = one.value.code(notation)
            head = f"static inline double rankdrop_{mark}_{one.mark}(const double q[{self.n}])"
            unused = [] if "q[" in text else ["    (void)q;"]
            lines += ["", f"/* {_comment(one.name)} of the Jacobian. q [rad, slides m]. */"]
            lines += [head, "{", *unused, f"    return {text};", "}"]
        return "\n".join([*lines, "", "#endif", ""])

    def _c_function(self, family: ExactFamily, prefix: str, notation: C) -> list[str]:
        residuals = [one.code(notation) for one in family.stated]
        lines = [f"/* {_comment(family.name)}, corank {family.corank}."]
        lines += [f" * {_comment(one.text())}" for one in family.stated]
        lines += [" * q [rad, slides m]; every residual is zero exactly on the family. */"]
        lines += [f"#define {prefix.upper()}_{_mark(family.id).upper()}_NAME \"{_plain(family.name)}\""]
        head = f"{prefix}_{_mark(family.id)}(const double q[{self.n}], double residual[{len(residuals)}])"
        body = [f"    residual[{place}] = {text};" for place, text in enumerate(residuals)]
        return [*lines, f"static inline void {head}", "{", *body, "}"]

    def _c_gradient(self, family: ExactFamily, prefix: str, notation: C) -> list[str]:
        rows = [one.gradient(notation) for one in family.stated]
        body = [f"    gradient[{i}][{j - 1}] = {text};" for i, row in enumerate(rows) for j, text in row.items()]
        unused = [] if any("q[" in line for line in body) else ["    (void)q;"]
        head = f"{prefix}_{_mark(family.id)}_gradient(const double q[{self.n}], double gradient[{len(rows)}][{self.n}])"
        return [
            "/* Derivatives of the residuals by q. */", f"static inline void {head}", "{", "    int i, j;", *unused,
            f"    for (i = 0; i < {len(rows)}; ++i)", f"        for (j = 0; j < {self.n}; ++j) gradient[i][j] = 0.0;",
            *body, "}",
        ]  # fmt: skip

    def _c_distance(self, family: ExactFamily, prefix: str) -> list[str]:
        """Pinned joints to their nearest values, exactly; of the other conditions the largest |f|/|∇f|."""
        first, count = len(family.pins), len(family.pins) + len(family.conditions)
        name = f"{prefix}_{_mark(family.id)}"
        lines = ["/* Distance in joint space [rad, slides divided by the length]: pinned joints exactly, other",
                 " * conditions by one Newton step: right near the family, an estimate far from it. */"]  # fmt: skip
        body = ["    double square = 0.0, way;"] if first else ["    double square = 0.0;"]
        for pin in family.pins:
            shift = self.shifts[pin.joint - 1] if len(self.shifts) else 0.0
            for place, angle in enumerate(pin.angles):
                gap = f"fabs(remainder(q[{pin.joint - 1}] - ({float(angle - shift)!r}), {2 * pi!r}))"
                body.append(f"    way = {gap if place == 0 else f'fmin(way, {gap})'};")
            body.append("    square += way * way;")
        if family.conditions:
            scale = [f"            size += gradient[i][{j - 1}] * gradient[i][{j - 1}]"
                     f"{f' * {prefix.upper()}_LENGTH * {prefix.upper()}_LENGTH' if j in self._slides else ''};"
                     for j in range(1, self.n + 1)]  # fmt: skip
            body += [
                f"    double residual[{count}], gradient[{count}][{self.n}], most = 0.0;", "    int i;",
                f"    {name}(q, residual);", f"    {name}_gradient(q, gradient);",
                f"    for (i = {first}; i < {count}; ++i) {{", "        double size = 0.0, one;",
                *[line[4:] for line in scale],
                "        one = size > 0.0 ? fabs(residual[i]) / sqrt(size) : residual[i] == 0.0 ? 0.0 : HUGE_VAL;",
                "        most = fmax(most, one);", "    }", "    square += most * most;",
            ]  # fmt: skip
        return [*lines, f"static inline double {name}_distance(const double q[{self.n}])", "{", *body,
                "    return sqrt(square);", "}"]  # fmt: skip

    @property
    def _slides(self) -> frozenset[int]:
        return frozenset(j for family in self.families for one in family.conditions for j in one.ring.prismatic)

    def latex(self) -> str:
        """A table: mark, name, corank, conditions; below it the lengths, shifted angles and what s and c stand for."""
        rows = []
        for family in self.families:
            shown = r"; \newline ".join(f"${one.latex()}$" for one in family.stated)
            rows.append(rf"{family.id} & {_escaped(family.name)} & {family.corank} & {shown} \\")
        head = [r"\begin{tabular}{lp{0.3\linewidth}rp{0.5\linewidth}}", r"& family & corank & conditions \\", r"\hline"]
        values = [rf"${_latex_minor(one.name)} = {one.value.latex()}$" for one in self.determinants]
        if any(r"\tfrac" in row for row in [*rows, *values]):
            head = [r"% \tfrac needs \usepackage{amsmath}", *head]
        below = [rf"{latex_name(name)} = {float(value):.12g}\,\mathrm{{m}}" for name, value in self.letters.items()]
        for j, shift in self._shifted():
            sign = "-" if shift < 0 else "+"
            below.append(rf"\theta_{{{j}}} = q_{{{j}}} {sign} {latex_angle(abs(shift))}")
        if any(re.search(r"\b[sc]_", row) for row in [*rows, *values]):
            below += [r"s_i = \sin\theta_i", r"c_{ij} = \cos(\theta_i + \theta_j)"]
        tail = [r"\par\smallskip", ", ".join(f"${text}$" for text in below)] if below else []
        said = [line for value in values for line in (r"\par\smallskip", value)]
        return "\n".join([*head, *rows, r"\end{tabular}", *said, *tail, ""])

    def _shifted(self) -> Iterator[tuple[int, float]]:
        yield from ((j, float(shift)) for j, shift in enumerate(self.shifts, 1) if shift)

    def _explained(self) -> list[str]:
        lines = [
            f"q1 to q{self.n} are joint variables in rad, those of slides in m; lengths are in m.",
            "A configuration lies on a family where all residuals are zero. s_i = sin θi, c_ij = cos(θi + θj).",
        ]
        shifted = [f"θ{j} = q{j} {'−' if s < 0 else '+'} {abs(s):.12g} rad" for j, s in self._shifted()]
        return [*lines, f"In the words on a condition {', '.join(shifted)}."] if shifted else lines

    def _in(self, *polynomials: Polynomial) -> list[str]:
        """Lengths that occur in polynomials."""
        found = {name for f in polynomials for name, d in zip(f.context().names(), f.degrees(), strict=True) if d > 0}
        return [name for name in self.letters if name in found]


def _mark(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_").lower() or "arm"


def _function(text: str) -> str:
    """A mark as a Python name."""
    mark = _mark(text)
    return f"family_{mark}" if mark[0].isdigit() or iskeyword(mark) or mark in TAKEN else mark


def _plain(text: str) -> str:
    return " ".join(text.replace("\\", "/").replace('"', "'").split())


def _comment(text: str) -> str:
    return " ".join(text.replace("*/", "* /").replace("/*", "/ *").replace("\\", "/").replace("??", "? ?").split())


def _latex_minor(name: str) -> str:
    r"""det J11 → \det J_{11}, |$1 $2| → |\$_1 \, \$_2|, |vx wz| → |v_x \, w_z|."""
    if name.startswith("det "):
        return rf"\det {latex_name(name[4:])}"
    words = (rf"\${word[1:] and '_' + word[1:]}" if word[0] == "$" else f"{word[0]}_{word[1:]}" for word in
             name.strip("|").split())  # fmt: skip
    return "|" + r" \, ".join(words) + "|"


def _escaped(text: str) -> str:
    special = {"\\": r"\textbackslash{}", "−": "$-$", "±": r"$\pm$", "θ": r"$\theta$", "π": r"$\pi$", "≠": r"$\neq$"}
    special |= {"∥": r"$\parallel$", "⟂": r"$\perp$", "–": "--"}
    special |= {letter: f"\\{letter}" for letter in "&%$#_{}"} | {"~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
    return "".join(special.get(letter, letter) for letter in text)
