"""Conditions of a method in words: factors joined by "or", polynomials by "and", exceptions at the end."""

from __future__ import annotations

from collections.abc import Sequence

from rankdrop.exact.algebra.atom import Atom
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.methods.derivation import Conjunction, Equality
from rankdrop.exact.writing.condition import Condition
from rankdrop.exact.writing.fourier import fourier
from rankdrop.exact.writing.notation import Text
from rankdrop.exact.writing.pins import pin_text
from rankdrop.exact.writing.text_of import condition_text, single_angles

READABLE = 30
"""Polynomials of more terms are told by their number of terms: nobody reads them."""


class Words:
    """Conditions of one ring in words; the shortest form of a polynomial is looked for once.

    Args:
        ring: of the chain.
        whole: write every polynomial out; long ones as they are, without a search for their shortest form.

    Example:
        >>> ring = Ring([1, 2])
        >>> atoms = tuple(atom for atom, _ in ring.factor(ring.s[1] * (ring.c[2] - ring.s[2])).atoms)
        >>> Words(ring).conjunction(Conjunction((Equality(atoms),), ((Equality((ring.pin(2, "pi"),)),),)))
        'θ1 = 0 or π or c2 − s2 = 0, where θ2 ≠ π'
    """

    def __init__(self, ring: Ring, *, whole: bool = False) -> None:
        self._ring, self._whole = ring, whole
        self._known: dict[Atom, str] = {}

    def conjunction(self, conjunction: Conjunction) -> str:
        """Everything that has to hold: "θ4 = 0 and (s2 = 0 or …), where θ6 ≠ 0"."""
        equal = [self.equality(equality) for equality in conjunction.equal]
        text = " and ".join(_bracketed(part) if len(equal) > 1 else part for part in equal) or "everywhere"
        unequal = [self._unequal(group) for group in conjunction.unequal]
        return f"{text}, where {' and '.join(unequal)}" if unequal else text

    def equality(self, equality: Equality) -> str:
        """One polynomial that vanishes: its factors, joined by "or"; joints at simple angles together."""
        if equality.whole is not None:
            count = len(equality.whole)
            if count <= READABLE:
                return condition_text(self._ring, equality.whole)
            if not self._whole:
                return _long(count, "")
            return f"{Text().zero(single_angles(self._ring, equality.whole))} = 0"
        pins: dict[int, list[str]] = {}
        for atom in equality.atoms:
            if atom.pinned:
                pins.setdefault(atom.joint, []).append(atom.value)
        texts = [pin_text(joint, values) for joint, values in sorted(pins.items())]
        return " or ".join([*texts, *(self._polynomial(atom) for atom in equality.atoms if not atom.pinned)])

    def _polynomial(self, atom: Atom) -> str:
        if atom not in self._known:
            if len(atom.f) <= READABLE:
                self._known[atom] = Condition(self._ring, atom.f).text()
            else:
                self._known[atom] = self._written(atom.f) if self._whole else _long(len(atom.f), "half-angle ")
        return self._known[atom]

    def _written(self, f: Polynomial) -> str:
        """A long half-angle polynomial: in sines and cosines where it has whole angles, else multiplied out."""
        p = self._ring.to_trig(f)
        if p is not None:
            return f"{Text().zero(single_angles(self._ring, p))} = 0"
        degrees = [int(d) for d in f.degrees()[: self._ring.angles]]
        return f"{Text().zero(fourier(f, degrees, self._ring))} = 0"

    def _unequal(self, group: Sequence[Equality]) -> str:
        texts = [self.equality(equality) for equality in group]
        if len(texts) > 1:
            return "not all of these hold: " + "; ".join(texts)
        if texts[0].count(" = ") == 1 and " or " not in texts[0]:
            return texts[0].replace(" = ", " ≠ ")
        return f"not ({texts[0]})"


def _long(count: int, kind: str) -> str:
    return f"a polynomial of {count} {kind}terms = 0"


def _bracketed(text: str) -> str:
    return f"({text})" if " or " in text else text
