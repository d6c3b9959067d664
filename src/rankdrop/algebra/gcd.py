"""Quotients and greatest common divisors of polynomials, over roots from images modulo primes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import islice, product
from math import isqrt, lcm, prod
from typing import Any

from rankdrop.algebra.halt import Halt, HaltKind, TooLong
from rankdrop.algebra.matrix import entries
from rankdrop.algebra.polynomial import Polynomial, flint, look, primitive, root_relations, roots_in, variables_of
from rankdrop.algebra.roots import PRIMES, embeddings, primes_with, residues_of_roots

_LIFTED = 256  # primes, for coefficients of 8,000 bits

Combine = Callable[[Polynomial, Polynomial], Polynomial | None]


def quotient(f: Polynomial, g: Polynomial) -> Polynomial | None:
    """f / g; None where g does not divide f. Over the roots from images modulo primes, tested modulo one more.

    Raises:
        TooLong: the primes do not suffice for its coefficients.
    """
    if not any(g.degrees()[place] for place, _ in root_relations(g.context())):
        return _exact(f, g)
    return _from_images(f, g, _exact, lambda h, f, g: h * g == f)


def _exact(f: Polynomial, g: Polynomial) -> Polynomial | None:
    result, rest = divmod(f, g)
    return result if rest == 0 else None


def divides(h: Polynomial, f: Polynomial) -> bool:
    """Whether a polynomial divides another one that is not 0; over the roots modulo a prime of 61 bits."""
    if f == 0:
        return False
    if roots_in(f):
        f, prime = modulo_prime(f)
        h, _ = modulo_prime(h, prime)
    return bool(divmod(f, h)[1] == 0)


def gcd(f: Polynomial, g: Polynomial) -> Polynomial:
    """A greatest common divisor: over the roots from its images modulo primes, tested modulo one more.

    Raises:
        TooLong: the primes do not suffice for its coefficients.
    """
    look()
    if not (roots_in(f) and f != 0 and g != 0):
        return f.gcd(g)
    divisor = _from_images(f, g, _common, lambda h, f, g: divmod(f, h)[1] == 0 and divmod(g, h)[1] == 0)
    if divisor is None:
        return f.context().constant(1)
    return primitive(divisor)


def _common(f: Polynomial, g: Polynomial) -> Polynomial | None:
    common = f.gcd(g)
    if common.is_constant():
        return None
    return common


def _lifting(names: tuple[str, ...]) -> Iterator[int]:
    """Primes modulo which roots exist: all of `primes_with` but the last, then those below `PRIMES`."""
    known = primes_with(names)[:-1]
    yield from known
    below = (p for p in range(PRIMES[-1] - 4, 0, -4) if flint().fmpz(p).is_prime())
    further = (p for p in below if residues_of_roots(names, p) is not None)
    yield from islice(further, _LIFTED - len(known))


def _from_images(
    f: Polynomial, g: Polynomial, combine: Combine, holds: Callable[[Polynomial, Polynomial, Polynomial], bool]
) -> Polynomial | None:
    """What two polynomials over the roots are combined into, from its images modulo primes; None where one has none.

    Args:
        f, g: the polynomials.
        combine: their images, for one choice of signs of the roots.
        holds: whether an image of the result is right for those of both, modulo a prime that it was not made from.
    """
    names = roots_in(f)
    last = primes_with(names)[-1]
    both = (_Images(f), _Images(g))
    there = [images.with_roots(residues_of_roots(names, last) or {}, last) for images in both]
    known: dict[tuple[int, ...], int] = {}
    modulus = 1
    for number, prime in enumerate(_lifting(names), 1):
        look()
        image = _combine_images(both, names, prime, combine)
        if image is None:
            return None
        step = pow(modulus, -1, prime)
        known = {e: (a := known.get(e, 0)) + modulus * ((image.get(e, 0) - a) * step % prime)
                 for e in {*known, *image}}  # fmt: skip
        modulus *= prime
        if number < 8 or number % 8 == 0:
            candidate = _rational(known, modulus, f.context())
        else:
            candidate = None
        if candidate is not None and holds(modulo_prime(candidate, last)[0], *there):
            return candidate
    raise TooLong(Halt(HaltKind.COEFFICIENTS))


def _combine_images(
    images_of: tuple[_Images, _Images], names: tuple[str, ...], prime: int, combine: Combine
) -> dict[tuple[int, ...], int] | None:
    """Coefficients modulo a prime of the combination of two polynomials, by the powers of all variables."""
    f, g = images_of
    places = f.root_places
    basis = list(product((0, 1), repeat=len(places)))
    choices, images = list(embeddings(names, prime)), []
    for choice in choices:
        look()
        both = combine(f.with_roots(choice, prime), g.with_roots(choice, prime))
        if both is None:
            return None
        images.append({tuple(map(int, e)): int(c) for e, c in both.to_dict().items()})
    rows = [[prod(choice[name] ** e for name, e in zip(names, powers, strict=True)) % prime for powers in basis]
            for choice in choices]  # fmt: skip
    inverse = flint().nmod_mat(len(rows), len(rows), entries(rows), prime).inv().tolist()
    result: dict[tuple[int, ...], int] = {}
    for e in set(entries(images)):
        values = [image.get(e, 0) for image in images]
        for powers, row in zip(basis, inverse, strict=True):
            value = sum(int(x) * y for x, y in zip(row, values, strict=True)) % prime
            if value:
                whole = list(e)
                for place, power in zip(places, powers, strict=True):
                    whole[place] = power
                result[tuple(whole)] = value
    return result


def image_modulo(f: Polynomial, values: Mapping[str, int], prime: int) -> Polynomial:
    """f modulo a prime with values for some variables (`flint.nmod_mpoly` in the same variables).

    Values of the last variables (roots) are put in term by term: fewer terms are converted, which takes most of the
    time.
    """
    module, names = flint(), variables_of(f.context())
    context = module.nmod_mpoly_ctx.get(list(names), prime, module.Ordering.lex)
    first = len(names)
    while first and names[first - 1] in values:
        first -= 1
    zeros = (0,) * (len(names) - first)
    shares: dict[tuple[int, ...], int] = {}
    terms: dict[tuple[int, ...], int] = {}
    for powers, number in zip(f.monoms(), f.coeffs(), strict=True):
        value = int(number.p) % prime
        if number.q != 1:
            value = value * pow(int(number.q), -1, prime) % prime
        tail = powers[first:]
        share = shares.get(tail)
        if share is None:
            share = prod(pow(values[name], int(e), prime) for name, e in zip(names[first:], tail, strict=True)) % prime
            shares[tail] = share
        key = powers[:first] + zeros
        terms[key] = (terms.get(key, 0) + value * share) % prime
    before = {name: value for name, value in values.items() if name in names[:first]}
    image = context.from_dict({powers: value for powers, value in terms.items() if value})
    if before:
        return image.subs(before)
    return image


class _Images:
    """Images of a polynomial over the roots modulo primes: its terms are read once, and converted once for a prime.

    Args:
        f: the polynomial, Σ w^e · f_e with powers w^e of the roots and rational f_e.
    """

    def __init__(self, f: Polynomial) -> None:
        self._names = variables_of(f.context())
        self._first = len(self._names) - len(root_relations(f.context()))
        zeros = (0,) * (len(self._names) - self._first)
        values = f.coeffs()
        self._bottom = lcm(*(int(value.q) for value in values))
        self._parts: dict[tuple[int, ...], dict[tuple[int, ...], int]] = {}
        for powers, value in zip(f.monoms(), values, strict=True):
            whole = int(value.p) * (self._bottom // int(value.q))
            self._parts.setdefault(powers[self._first :], {})[powers[: self._first] + zeros] = whole
        self._prime = 0
        self._images: list[tuple[tuple[int, ...], Polynomial]] = []

    @property
    def root_places(self) -> range:
        """Places of the roots among the variables: the last ones."""
        return range(self._first, len(self._names))

    def with_roots(self, roots: Mapping[str, int], prime: int) -> Polynomial:
        """f modulo a prime for one choice of signs of the roots (`flint.nmod_mpoly` in the same variables)."""
        module = flint()
        context = module.nmod_mpoly_ctx.get(list(self._names), prime, module.Ordering.lex)
        if prime != self._prime:
            self._prime = prime
            self._images = [
                (powers, context.from_dict({e: rest for e, value in part.items() if (rest := value % prime)}))
                for powers, part in self._parts.items()
            ]
        total, inverse = context.constant(0), pow(self._bottom, -1, prime)
        for powers, image in self._images:
            power_of = zip(self._names[self._first :], powers, strict=True)
            share = prod(pow(roots[name], int(e), prime) for name, e in power_of) % prime
            total += image * (share * inverse % prime)
        return total


def _rational(terms: Mapping[tuple[int, ...], int], modulus: int, context: Any) -> Polynomial | None:
    """The polynomial with small rational coefficients that are these modulo a number; None where one is not small."""
    bound, coefficients = isqrt(modulus // 2), {}
    for e, value in terms.items():
        (a, b), (s, t) = (modulus, value % modulus), (0, 1)
        while b > bound:
            a, b, s, t = b, a % b, t, s - a // b * t
        if abs(t) > bound or t == 0:
            return None
        coefficients[e] = flint().fmpq(b if t > 0 else -b, abs(t))
    return context.from_dict(coefficients)


def modulo_prime(f: Polynomial, prime: int = 0) -> tuple[Polynomial, int]:
    """f modulo a prime with its roots, the first one if none is given; and the prime."""
    prime = prime or primes_with(roots_in(f))[0]
    return image_modulo(f, residues_of_roots(roots_in(f), prime) or {}, prime), prime
