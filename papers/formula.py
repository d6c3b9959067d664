"""Printed formulas evaluated as they stand: "a s345 + d c34 + d c3", at many configurations at once.

The grammar is that of `rankdrop.formula.reading`: s345 is sin(θ3 + θ4 + θ5), a product needs no sign, and c is a length
where the letters say so.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from rankdrop.errors import OptionError
from rankdrop.formula import Node, read
from rankdrop.robot import Array

_WAVE = re.compile(r"([sc])([1-9]+)")
_ANGLE = re.compile(r"(?:θ|q|theta)([1-9])")


def value(text: str, theta: Array, letters: Mapping[str, float]) -> Array:
    """The value of one formula.

    Args:
        text: as above, without "=".
        theta: (..., n) joint variables [rad or m].
        letters: lengths by name [m].

    Returns:
        (...,).

    Raises:
        OptionError: the text does not follow the grammar, or names what there is not.

    Example:
        >>> float(value("a s12 + 2 c1", np.array([0.0, np.pi / 2]), {"a": 3.0}))
        5.0
    """
    left = read(text, frozenset(letters))[0].parts[0]
    return np.broadcast_to(_value(left, np.asarray(theta, dtype=np.float64), letters), np.shape(theta)[:-1])


def matrix(rows: str | Sequence[Sequence[str]], theta: Array, letters: Mapping[str, float]) -> Array:
    """(..., r, k) values of a printed matrix: rows on lines, entries between bars, or given as a list of lists."""
    if isinstance(rows, str):
        rows = [[cell.strip() for cell in line.split("|")] for line in rows.strip().splitlines()]
    return np.stack([np.stack([value(cell, theta, letters) for cell in row], axis=-1) for row in rows], axis=-2)


def _value(node: Node, theta: Array, letters: Mapping[str, float]) -> Array:
    parts = [_value(part, theta, letters) for part in node.parts]
    if node.kind == "number":
        return np.float64(node.number)  # type: ignore[return-value]  # a number of any shape
    if node.kind == "name":
        return _named(node.name, theta, letters)
    if node.kind in ("sin", "cos"):
        return np.asarray(np.sin(parts[0]) if node.kind == "sin" else np.cos(parts[0]))
    if node.kind == "+":
        return np.asarray(sum(parts[1:], parts[0]))
    if node.kind == "-":
        return np.asarray(-parts[0] if len(parts) == 1 else parts[0] - parts[1])
    if node.kind == "*":
        return np.asarray(np.multiply.reduce(np.broadcast_arrays(*parts)))
    if node.kind == "/":
        return np.asarray(1.0 / parts[0])
    if node.kind == "**":
        return np.asarray(parts[0] ** float(node.number))
    raise OptionError("a formula has one value", got=node.kind)


def _named(name: str, theta: Array, letters: Mapping[str, float]) -> Array:
    if name in letters:
        return np.float64(letters[name])  # type: ignore[return-value]  # a number of any shape
    if name in ("pi", "π"):
        return np.float64(np.pi)  # type: ignore[return-value]  # a number of any shape
    wave, angle = _WAVE.fullmatch(name), _ANGLE.fullmatch(name)
    if wave:
        total = sum(theta[..., int(j) - 1] for j in wave.group(2))
        return np.asarray(np.sin(total) if wave.group(1) == "s" else np.cos(total))
    if angle:
        return np.asarray(theta[..., int(angle.group(1)) - 1])
    raise OptionError("nothing in this formula has that name", got=name, allowed=", ".join(letters))
