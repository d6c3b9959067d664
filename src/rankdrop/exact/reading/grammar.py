"""Reading a condition that a person wrote: text to tokens to a tree, with the place of every mistake.

    conditions  = condition {(";" | "," | "and") condition}
    condition   = sum ["=" sum {"or" sum}]
    sum         = ["-"] product {("+" | "-") product}
    product     = power {["*"] power | "/" power}          a2 c2 is a2*c2
    power       = primary [("**" | "^") whole number]      c5² too
    primary     = number | name | "(" sum ")" | "±" power
                | ("sin" | "cos" | "s" | "c") [power] ("(" sum ")" | name)
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction

from rankdrop.errors import OptionError

LONGEST = 10_000
"""Characters of a condition."""
DEEPEST = 60
"""Brackets in brackets."""
DIGITS = 40
"""Of a number."""
HIGHEST = 40
"""Power."""
WAVES = {"sin": "sin", "cos": "cos", "s": "sin", "c": "cos"}
SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹"
_SIGNS = {"−": "-", "–": "-", "·": "*", "×": "*", "^": "**"}
_TOKEN = re.compile(
    r"(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[A-Za-zθπ][A-Za-z0-9_]*)|(?P<raised>[⁰¹²³⁴⁵⁶⁷⁸⁹]+)"
    r"|(?P<sign>\*\*|[-+*/^()=;,±−–·×])|(?P<space>\s+)|(?P<other>.)",
    re.DOTALL,
)

_KNOWN = re.compile(r"[qθsct]\d+|pi|π")
"""Names that a bracket may follow as a factor: s2 (a2 + a3)."""


@dataclass(frozen=True, slots=True)
class Token:
    """A piece of text.

    Attributes:
        kind: "number", "name", "raised", "sign", or "end".
        text: the piece, signs in ASCII.
        place: where it starts, from 0.
    """

    kind: str
    text: str
    place: int


@dataclass(frozen=True, slots=True)
class Node:
    """A piece of the tree.

    Attributes:
        kind: "number", "name", "sin", "cos", "+", "-" (two parts or one), "*", "/", "**", "±".
        place: where it starts in the text, from 0.
        parts: what it is made of.
        name: of a name.
        number: of a number, or the whole power of "**".
    """

    kind: str
    place: int
    parts: tuple[Node, ...] = ()
    name: str = ""
    number: Fraction = Fraction(0)


@dataclass(frozen=True, slots=True)
class Statement:
    """One condition: left = right or right …; no right means that left is zero.

    Attributes:
        left, rights: trees.
        text: as written.
    """

    left: Node
    rights: tuple[Node, ...]
    text: str


def mistake(
    text: str, place: int, what: str, *, allowed: str | None = None, mend: str | None = None
) -> OptionError:
    """The error for a mistake at a place of the text, which is shown with a mark before the mistake."""
    start, stop = max(0, place - 30), min(len(text), place + 20)
    before, after = text[start:place], text[place:stop]
    shown = f"{'…' if start else ''}{before}▸{after}{'…' if stop < len(text) else ''}"
    return OptionError(what, where=f"condition, column {place + 1}", got=repr(shown), allowed=allowed, mend=mend)


def read(text: str, letters: frozenset[str] = frozenset()) -> tuple[Statement, ...]:
    """The conditions of a text.

    Args:
        text: as in the grammar above.
        letters: names of lengths; one called s or c is that length before a bracket, too.

    Raises:
        OptionError: the text does not follow the grammar, or is too long or too deep.
    """
    if len(text) > LONGEST:
        raise OptionError("the condition is too long", got=f"{len(text)} characters", allowed=f"up to {LONGEST}")
    return _Reader(text, letters).statements()


def _tokens(text: str) -> list[Token]:
    found = []
    for match in _TOKEN.finditer(text):
        kind = match.lastgroup or ""
        if kind == "other":
            what = "a character that means nothing in a condition"
            raise mistake(text, match.start(), what, allowed="+ − * / ** ( ) = ; ,")
        if kind != "space":
            found.append(Token(kind, _SIGNS.get(match.group(), match.group()), match.start()))
    return [*found, Token("end", "", len(text))]


class _Reader:
    """Goes through the tokens once."""

    def __init__(self, text: str, letters: frozenset[str]) -> None:
        self.text, self.letters = text, letters
        self.tokens = _tokens(text)
        self.at, self.depth = 0, 0

    @property
    def token(self) -> Token:
        """The token looked at."""
        return self.tokens[self.at]

    def take(self, *texts: str) -> Token | None:
        """The token where it is one of these signs or words; then the next one is looked at."""
        token = self.token
        if token.text in texts and token.kind in ("sign", "name"):
            self.at += 1
            return token
        return None

    def statements(self) -> tuple[Statement, ...]:
        """Statement { (; | , | and) Statement }, to the end; a Statement is a Sum [= Sum { or Sum }]."""
        found = []
        while True:
            start = self.token.place
            left = self.sum()
            rights = []
            if self.take("="):
                rights.append(self.sum())
                while self.take("or"):
                    rights.append(self.sum())
            found.append(Statement(left, tuple(rights), self.text[start : self.token.place].strip()))
            if self.token.kind == "end":
                return tuple(found)
            if self.take(";", ",", "and") is None:
                raise self.wrong("an operator or the end")
            if self.token.kind == "end" and self.tokens[self.at - 1].text == ";":
                return tuple(found)

    def wrong(self, allowed: str) -> OptionError:
        """What to raise where the token looked at does not belong."""
        what = "the condition ends too early" if self.token.kind == "end" else "this does not belong here"
        return mistake(self.text, self.token.place, what, allowed=allowed)

    def sum(self) -> Node:
        """[±] Product { (+ | −) Product }."""
        first = self.take("-", "+")
        node = self.product()
        if first is not None and first.text == "-":
            node = Node("-", first.place, (node,))
        parts = [node]
        while (sign := self.take("+", "-")) is not None:
            part = self.product()
            parts.append(Node("-", sign.place, (part,)) if sign.text == "-" else part)
        return parts[0] if len(parts) == 1 else Node("+", parts[0].place, tuple(parts))

    def product(self) -> Node:
        """Power { [* | /] Power }: side by side is a product, too."""
        parts = [self.power()]
        while True:
            sign = self.take("*", "/")
            if sign is None and not self.starts_primary():
                return parts[0] if len(parts) == 1 else Node("*", parts[0].place, tuple(parts))
            inverted = sign is not None and sign.text == "/"
            part = self.signed() if sign is not None else self.power()
            parts.append(Node("/", part.place, (part,)) if inverted else part)

    def starts_primary(self) -> bool:
        """Whether a factor without a sign may begin here."""
        token = self.token
        if token.kind == "name":
            return token.text not in ("and", "or")
        return token.kind == "number" or token.text == "("

    def signed(self) -> Node:
        """A power after * or /, where a sign may stand."""
        sign = self.take("-")
        node = self.power()
        return node if sign is None else Node("-", sign.place, (node,))

    def power(self) -> Node:
        """Primary [** whole number]."""
        node = self.primary()
        raised = self.raised()
        return node if raised is None else Node("**", node.place, (node,), number=Fraction(raised))

    def raised(self) -> int | None:
        """A power after a primary or after sin, if there is one."""
        token = self.token
        if token.kind == "raised":
            self.at += 1
            return self.whole("".join(str(SUPERSCRIPTS.index(letter)) for letter in token.text), token.place)
        if self.take("**") is None:
            return None
        token = self.token
        if token.kind != "number" or not token.text.isdecimal():
            raise mistake(self.text, token.place, "a power must be a whole number", allowed=f"0 … {HIGHEST}")
        self.at += 1
        return self.whole(token.text, token.place)

    def whole(self, digits: str, place: int) -> int:
        """The exponent, which may not be too high."""
        if len(digits) > 4 or int(digits) > HIGHEST:
            raise mistake(self.text, place, "the power is too high", allowed=f"0 … {HIGHEST}")
        return int(digits)

    def primary(self) -> Node:
        """A number, a name, a sine or cosine, ± a power, or a bracket."""
        token = self.token
        if token.kind == "number":
            self.at += 1
            return Node("number", token.place, number=self.value(token))
        if token.kind == "name" and token.text not in ("and", "or"):
            self.at += 1
            bracket = self.token.text == "(" or self.token.kind == "raised"
            if token.text in ("sin", "cos") or (token.text in WAVES and bracket and token.text not in self.letters):
                return self.wave(token)
            if self.token.text == "(" and token.text not in self.letters and not _KNOWN.fullmatch(token.text):
                raise mistake(self.text, token.place, f"there is no function {token.text}", allowed="sin, cos, s, c")
            return Node("name", token.place, name=token.text)
        if self.take("±"):
            return Node("±", token.place, (self.power(),))
        if token.text == "(":
            return self.bracket()
        raise self.wrong("a number, a name, sin, cos, or a bracket")

    def wave(self, token: Token) -> Node:
        """What follows sin or cos: an exponent, if there is one, and a bracket or a name."""
        raised = self.raised()
        if self.token.text == "(":
            inside = self.bracket()
        elif self.token.kind == "name" and self.token.text not in (*WAVES, "and", "or"):
            inside = Node("name", self.token.place, name=self.token.text)
            self.at += 1
        else:
            raise mistake(self.text, self.token.place, f"{token.text} needs an angle", allowed=f"{token.text}(q1 + q2)")
        node = Node(WAVES[token.text], token.place, (inside,))
        return node if raised is None else Node("**", token.place, (node,), number=Fraction(raised))

    def bracket(self) -> Node:
        """( Sum )."""
        opened = self.token
        self.at += 1
        self.depth += 1
        if self.depth > DEEPEST:
            raise mistake(self.text, opened.place, "brackets are nested too deeply", allowed=f"up to {DEEPEST}")
        node = self.sum()
        if self.take(")") is None:
            raise self.wrong(f"an operator, or the ) of the bracket opened at column {opened.place + 1}")
        self.depth -= 1
        return node

    def value(self, token: Token) -> Fraction:
        """A number as it is written, exactly."""
        digits, _, power = token.text.lower().partition("e")
        if len(digits) > DIGITS or len(power) > 3:
            allowed = f"{DIGITS} digits, powers of ten up to 99"
            raise mistake(self.text, token.place, "the number is too long", allowed=allowed)
        return Fraction(token.text)
