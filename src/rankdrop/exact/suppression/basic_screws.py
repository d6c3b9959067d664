"""Which six screws are the basic ones: independent in general, with a triple that is a joint of its own, contiguous,
and the shortest determinant (KG's conditions a, b, c).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from rankdrop.errors import OptionError
from rankdrop.exact.algebra.polynomial import Polynomial
from rankdrop.exact.algebra.work import Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.suppression.factors import Product, taken_apart
from rankdrop.exact.suppression.stratum import Stratum

Columns = Sequence[Sequence[Polynomial]]


@dataclass(frozen=True)
class Basic:
    """Six screws and their determinant on a stratum.

    Attributes:
        joints: their numbers.
        product: the determinant, taken apart.
        reason: why these, by KG's conditions; "" for a case that is not the first.
    """

    joints: tuple[int, ...]
    product: Product
    reason: str = ""


def check_basic(chain: Chain, basic: Sequence[int] | None) -> None:
    """Raises OptionError unless `basic` is None or six different joints of the chain."""
    if basic is not None and (len(set(basic)) != 6 or len(basic) != 6 or not set(basic) <= set(range(1, chain.n + 1))):
        raise OptionError(
            "the basic screws are six different joints", where="basic", got=str(list(basic)), allowed=f"1 … {chain.n}"
        )


def determinants(
    columns: Columns, stratum: Stratum, joints: Sequence[int], asked: tuple[int, ...] | None, work: Work
) -> list[tuple[tuple[int, ...], Polynomial]]:
    """The determinant of every six of these screws (v; ω), or of the six asked for, as it reads on a stratum."""
    ring = stratum.ring
    short = {j: [stratum.short(x) for x in columns[j - 1]] for j in joints}
    found = []
    for six in combinations(joints, 6) if asked is None else (asked,):
        work.check()
        found.append((six, stratum.short(ring.determinant([[short[j][r] for j in six] for r in range(6)]))))
    return found


def choose(
    chain: Chain,
    stratum: Stratum,
    options: Sequence[tuple[tuple[int, ...], Polynomial]],
    work: Work,
) -> Basic | None:
    """The best six whose determinant vanishes on no whole piece of a stratum; None where there is none."""
    known = triples(chain)

    def place(option: tuple[tuple[int, ...], Polynomial]) -> tuple[int, ...]:
        six, p = option
        return (not _with_triple(known, six), six[-1] - six[0], len(p), -six[0])

    found = None
    for six, p in sorted(options, key=place):
        work.check()
        if p == 0 or any(piece.vanishes(p, work.rng) for piece in stratum.pieces):
            continue
        product = taken_apart(stratum, p)
        if product is not None:
            found = Basic(six, product)
            break
    return found


def why(
    chain: Chain,
    stratum: Stratum,
    options: Sequence[tuple[tuple[int, ...], Polynomial]],
    chosen: tuple[int, ...],
    work: Work,
) -> str:
    """KG's conditions (a), (b), (c) in words, with how many sixes each leaves."""
    known = triples(chain)
    free = [
        (six, p) for six, p in options if p != 0 and not any(one.vanishes(p, work.rng) for one in stratum.pieces)
    ]
    with_triple = [(six, p) for six, p in free if _with_triple(known, six)]
    left = with_triple or free
    least = min(six[-1] - six[0] for six, _ in left)
    near = [(six, p) for six, p in left if six[-1] - six[0] == least]
    said = [f"(a) not dependent everywhere: {len(free)} of {len(options)} sixes"]
    if with_triple:
        names = ", ".join(f"{'–'.join(str(j) for j in (three[0], three[-1]))} ({kind})" for three, kind in known)
        said.append(f"(b) with three joints that are one, {names}: {len(with_triple)}")
    else:
        said.append("(b) no three joints are a planar or spherical one")
    chain_of = "in a row" if least == 5 else "as near to a row as can be"
    said.append(f"(c) {chain_of}: {len(near)}")
    if len(near) > 1:
        terms = ", ".join(f"{len(p)} for {_short(six)}" for six, p in near)
        shortest = min(len(p) for _, p in near)
        alike = sum(len(p) == shortest for _, p in near) > 1
        said.append(f"terms of the determinant: {terms}; {'of equals the last' if alike else 'the least'}")
    return "; ".join(said)


def _with_triple(known: Sequence[tuple[tuple[int, int, int], str]], six: Sequence[int]) -> bool:
    return any(set(joints) <= set(six) for joints, _ in known)


def _short(six: Sequence[int]) -> str:
    """1–6, or 1, 2, 4, 5, 6, 7."""
    return f"{six[0]}–{six[-1]}" if six[-1] - six[0] == len(six) - 1 else ", ".join(map(str, six))


def parse_joints(text: str) -> tuple[int, ...]:
    """Numbers of joints as people write them: "2-7", "1,2,4-7".

    Raises:
        OptionError: something else.
    """
    found: list[int] = []
    for word in text.replace("–", "-").replace(",", " ").split():
        first, _, last = word.partition("-")
        if not first.isdecimal() or ("-" in word and not last.isdecimal()):
            raise OptionError("these are no joints", got=repr(word), allowed="numbers and runs, such as 2-7 or 1,2,4-7")
        found += range(int(first), int(last or first) + 1)
    return tuple(found)


def triples(chain: Chain) -> list[tuple[tuple[int, int, int], str]]:
    """Three successive joints that are equivalent to a spherical or a planar joint.

    In the frame of the middle one (z along its axis) their screws have v = 0, or v_z = ω_x = ω_y = 0.
    """
    found = []
    for first in range(1, chain.n - 1):
        three = chain.screws(first + 1)[first - 1 : first + 2]
        for name, rows in (("spherical", (0, 1, 2)), ("planar", (2, 3, 4))):
            if all(column[r] == 0 for column in three for r in rows):
                found.append(((first, first + 1, first + 2), name))
    return found
