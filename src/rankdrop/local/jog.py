"""The jog that gets out: one joint, or two one after the other, after which the verdict is regular.

A configuration is regular where σ_r exceeds `small`, the nearest singular configuration is farther than `near`, and no
straight motion is slower than the speeds asked for. Jogs of every joint to both sides are tried in order of their size,
many at once, then jogs of two joints. σ_r, the first-order distance σ_r/‖∇σ_r‖ and the slowest motions are computed for
all of them; the nearest singular configuration is searched only from those that pass. A jog that crosses another
singularity on its way is advised only where none of the same number of joints, and of the same range, avoids that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np

from rankdrop.configuration import Configuration
from rankdrop.errors import OptionError
from rankdrop.local.block import block
from rankdrop.local.nearest import nearest_singularity
from rankdrop.local.slowest import slowest_motions
from rankdrop.questions import ExplainOptions
from rankdrop.robot.model import Array
from rankdrop.units import into_metres

_SIZES = (4, 6, 8, 10, 12, 15, 20, 30, 45, 60)  # jogs of one joint [°; slides by the same share]
_LARGE = (75, 90, 120, 150)  # of one joint, where two joints by less do not get out
_PAIRED = (4, 8, 15, 30, 60)  # of each of two joints
_LEAST = 0.5  # a jog below it is none [°]
_MARGIN = 1.1  # a jog is not exact: the bars of the verdict are exceeded by a tenth
_FIRST_ORDER = 0.4  # the distance is hardly larger than σ_r/‖∇σ_r‖, or twice that where σ_r is of second order
_BEYOND = 1.0 + 1e-6  # a search stops at the tolerance of σ_r, a little before a singular configuration
_SEARCHES = 40  # searches of the nearest singular configuration
_SAMPLES, _FINER, _ROUNDS = 33, 17, 6  # configurations along a joint's motion, and around a minimum, so many times
_CROSSED = 1e-6  # a minimum of σ on the way at or below this is a singular configuration
WORTH = 1.01
"""From a regular configuration a jog that raises σ_r by a smaller factor is none."""

Free = Callable[[Array, float], bool]
"""Whether it is proven that no configuration within a distance [rad] of q (n,) is singular."""


@dataclass(frozen=True, slots=True)
class Jog:
    """Jogs of one joint or two, and what the configuration after them is.

    Attributes:
        moves: (number, step) of the joints to jog, one after the other [rad, m]; empty where none was found.
        regular: σ_r, distance and speeds exceed the bars of the verdict after them.
        sigma_after: σ_r then; None where there is no jog.
        crosses: another singular configuration lies on the way.
    """

    moves: tuple[tuple[int, float], ...]
    regular: bool
    sigma_after: float | None
    crosses: bool = False


_NONE = Jog((), regular=False, sigma_after=None)


def _nothing_proven(_q: Array, _radius: float) -> bool:
    return False


def jog_out(here: Configuration, options: ExplainOptions, free: Free = _nothing_proven) -> Jog:
    """The smallest jog of one joint, or of two, that ends inside the limits at a regular configuration.

    Args:
        here: the configuration to leave.
        options: `near`, `small`, `speed`, `turn_speed` decide what is regular; `limits`, `seed` as in `explain`.
        free: asked first whether the neighbourhood of an end is proven free, which takes less time than a search.

    Returns:
        The jog. Where none ends regular: the jog to full rank after which the slowest motion is fastest, or nothing.

    Example:
        >>> from rankdrop.configuration import configuration_at
        >>> from rankdrop.robot.open import open_robot
        >>> here = configuration_at(open_robot("puma560"), [0.3, 0.5, 0.4, 0.2, 0.0, 0.6])
        >>> jog = jog_out(here, ExplainOptions())
        >>> [(number, round(float(np.degrees(step)), 1)) for number, step in jog.moves], jog.regular
        ([(5, -4.0)], True)
    """
    trial = _JogTrial(here, options, free)
    for jogs in (_single_joint_jogs(here, _SIZES), _in_pairs(here), _single_joint_jogs(here, _LARGE)):
        trial.run(jogs)
        if trial.found is not None:
            return trial.found
        if trial.crossing is not None:
            return trial.crossing
    return trial.second or _NONE


def jog_farther(here: Configuration, options: ExplainOptions, free: Free = _nothing_proven) -> Jog:
    """The jog of one joint by `options.step` that raises σ_r most; no motion where σ_r grows by less than 1 %.

    Arguments as for `jog_out`.
    """
    size = max(float(np.degrees(options.step)), _LEAST)
    trial = _JogTrial(here, options, free)
    jogs = trial.within_limits(next(_single_joint_jogs(here, (size,))))
    if not len(jogs):
        return _NONE
    sigma = trial.estimates(here.q + jogs)[0]
    for row in np.argsort(-sigma):
        if sigma[row] < WORTH * here.measured.sigma[here.generic - 1]:
            break
        if trial.regular(jogs[row]):
            return trial.jog(jogs[row], float(sigma[row]), regular=True)
    return _NONE


def _steps(here: Configuration, sizes: tuple[float, ...]) -> Array:
    """(n, sizes) jogs [rad, m]; a slide moves by the same share of the length scale, to two digits."""
    steps = np.radians(sizes) * here.scale[:, None]
    for j, joint in enumerate(here.robot.variables):
        if joint.unit == "m":
            steps[j] = [float(f"{step:.2g}") for step in steps[j]]
    return steps


def _single_joint_jogs(here: Configuration, sizes: tuple[float, ...]) -> Iterator[Array]:
    """Jogs (2n, n) of one joint to both sides, for each size."""
    for steps in _steps(here, sizes).T:
        yield np.concatenate([np.diag(steps), np.diag(-steps)])


def _in_pairs(here: Configuration) -> Iterator[Array]:
    """Jogs (4P, n) of two joints to both sides, P pairs, for each two sizes, smallest first."""
    steps, pairs = _steps(here, _PAIRED), list(combinations(range(len(here.q)), 2))
    if not pairs:
        return
    first, second = np.array(pairs).T
    sizes = sorted(product(range(len(_PAIRED)), repeat=2), key=lambda pair: sum(_PAIRED[i] for i in pair))
    for first_size, second_size in sizes:
        jogs = np.zeros((4, len(pairs), len(here.q)))
        rows = np.arange(len(pairs))
        for side, (sign, sign_of_second) in enumerate(product((1.0, -1.0), repeat=2)):
            jogs[side, rows, first] = sign * steps[first, first_size]
            jogs[side, rows, second] = sign_of_second * steps[second, second_size]
        yield jogs.reshape(-1, len(here.q))


class _JogTrial:
    """Jogs (N, n) from one configuration, tried in the order given; searches begin at that configuration as well."""

    def __init__(self, here: Configuration, options: ExplainOptions, free: Free) -> None:
        self.here, self.options, self.free = here, options, free
        self.found: Jog | None = None
        self.crossing: Jog | None = None  # the first that ends regular and crosses a singularity on its way
        self.second: Jog | None = None  # to full rank, the slowest motion as fast as can be
        self._fastest = 0.0
        self._searches = 0
        self._provable = True

    def within_limits(self, jogs: Array) -> Array:
        """Those that end inside the limits; a joint beyond a limit may move back towards it."""
        robot, q = self.here.robot, self.here.q
        ends = q + jogs
        outside = np.maximum(np.maximum(robot.lower - ends, ends - robot.upper), 0.0)
        before = np.maximum(np.maximum(robot.lower - q, q - robot.upper), 0.0)
        good = (outside == 0.0) | (outside < before) | (jogs == 0.0)
        return np.asarray(jogs[good.all(axis=1)])

    def run(self, every: Iterable[Array]) -> None:
        """Find the first jog of some (N, n) that ends regular."""
        here, options = self.here, self.options
        for jogs in every:
            inside = self.within_limits(jogs)
            if here.measured.corank:  # the configuration itself is singular, and that near
                inside = inside[np.linalg.norm(inside / here.scale, axis=1) > _MARGIN * options.near]
            if len(inside):
                self._some(inside)
            if self.found is not None:
                return

    def _some(self, jogs: Array) -> None:
        """Find the first of a few jogs that ends regular."""
        ends, options = self.here.q + jogs, self.options
        sigma, estimate = self.estimates(ends)
        least = max(_MARGIN * options.small, self.here.tolerances.singular)
        passing = np.flatnonzero((sigma > least) & (estimate > _FIRST_ORDER * options.near))
        passing = passing[np.argsort(-sigma[passing].round(9), kind="stable")]
        if not len(passing):
            return
        speed = self._speeds(ends[passing])
        for row, share in zip(passing, speed, strict=True):
            if share <= _MARGIN:
                continue
            crosses = self.crosses_singularity(jogs[row])
            if crosses and self.crossing is not None:
                continue
            if not self._is_clear(ends[row], float(estimate[row])):
                continue
            jog = self.jog(jogs[row], float(sigma[row]), regular=True)
            if not crosses:
                self.found = jog
                return
            self.crossing = replace(jog, crosses=True)
        best = int(np.minimum(speed, _MARGIN).argmax())
        if speed[best] > self._fastest:
            self._fastest = float(speed[best])
            self.second = self.jog(jogs[passing[best]], float(sigma[passing[best]]), regular=False)

    def regular(self, jog: Array) -> bool:
        """Whether one jog (n,) ends regular."""
        end = self.here.q + jog
        sigma, estimate = (float(values[0]) for values in self.estimates(end[None]))
        least = max(_MARGIN * self.options.small, self.here.tolerances.singular)
        return sigma > least and bool(self._speeds(end[None])[0] > _MARGIN) and self._is_clear(end, estimate)

    def jog(self, step: Array, sigma: float, *, regular: bool) -> Jog:
        """The record of a jog (n,)."""
        moves = tuple((int(j) + 1, float(step[j])) for j in np.flatnonzero(step))
        return Jog(moves, regular, sigma)

    def crosses_singularity(self, jog: Array) -> bool:
        """Whether the joints of a jog (n,), moved one after the other, pass another singular configuration."""
        start = self.here.q.copy()
        moves = np.flatnonzero(jog)
        for number in moves:
            leg = np.zeros_like(jog)
            leg[number] = jog[number]
            if self._leg_crosses(start, leg, to_the_end=bool(number != moves[-1])):
                return True
            start = start + leg
        return False

    def _leg_crosses(self, start: Array, leg: Array, *, to_the_end: bool) -> bool:
        """Whether the rank drops between the start and the end of one joint's motion (n,), or at the end as well.

        Where the motion keeps a rank below the generic one, a drop below that rank counts.
        """
        shares = np.linspace(0.0, 1.0, _SAMPLES)
        sigma = self._sigma(start + shares[:, None] * leg)
        kept = int((sigma > self.here.tolerances.singular).sum(axis=1).max())
        if not kept:
            return False
        values = sigma[:, kept - 1]
        if to_the_end and values[-1] <= _CROSSED:
            return True
        before, after = np.append(np.inf, values[:-1]), np.append(values[1:], np.inf)
        step = 1.0 / (_SAMPLES - 1)
        for least in np.flatnonzero((values <= before) & (values <= after)):
            if least == 0 and values[0] <= _CROSSED:  # the singularity that is left
                continue
            low, high = max(shares[least] - step, 0.0), min(shares[least] + step, 1.0)
            if self._least_sigma(start, leg, (low, high), kept) <= _CROSSED:
                return True
        return False

    def _least_sigma(self, start: Array, leg: Array, between: tuple[float, float], rank: int) -> float:
        """The minimum of the singular value of a rank between two shares of a motion (n,)."""
        low, high = between
        least = np.inf
        for _ in range(_ROUNDS):
            shares = np.linspace(low, high, _FINER)
            values = self._sigma(start + shares[:, None] * leg)[:, rank - 1]
            best = int(values.argmin())
            least = float(values[best])
            low, high = shares[max(best - 1, 0)], shares[min(best + 1, _FINER - 1)]
        return least

    def _sigma(self, q: Array) -> Array:
        """(N, r) singular values of the arm in metres, r the generic rank."""
        here = self.here.metric
        return here.singular_values(into_metres(self.here.robot, q))[:, : here.generic]

    def estimates(self, ends: Array) -> tuple[Array, Array]:
        """(N,) σ_r and (N,) σ_r/‖∇σ_r‖, the distance to first order [rad]."""
        here = self.here.metric
        parts = block(here.robot, into_metres(self.here.robot, ends), here.task, here.generic - 1)
        gradient = np.linalg.norm(parts.d[:, 0, 0, :] * here.scale, axis=1)
        sigma = parts.sigma[:, here.generic - 1]
        return sigma, sigma / np.maximum(gradient, 1e-300)

    def _speeds(self, ends: Array) -> Array:
        """(N,) the slowest straight motion as a multiple of the speed asked for; inf without rate limits."""
        here, options = self.here, self.options
        least = np.full(len(ends), np.inf)
        if here.generic < here.task.m:
            return least
        bars = {"m/s": options.speed, "rad/s": options.turn_speed}
        for motion in slowest_motions(here.robot, ends, here.task):
            if bars[motion.unit] > 0.0:
                least = np.minimum(least, motion.speed / bars[motion.unit])
        return least

    def _is_clear(self, end: Array, estimate: float) -> bool:
        """Whether no singular configuration is found within `near`; `estimate`: the distance to first order."""
        here, options = self.here, self.options
        self._searches += 1
        if self._searches > _SEARCHES:
            return False
        bar = _MARGIN * options.near
        if self._provable and estimate > bar:  # where one proof failed the next ones would, most often
            if self.free(end, bar * _BEYOND):
                return True
            self._provable = False
        task = replace(here.task, length_scale=here.task.scale(here.robot))
        try:
            nearest = nearest_singularity(
                here.robot, end, task, limits=options.limits, seed=options.seed, seeds=(here.q,),
                tolerances=here.tolerances,
            )  # fmt: skip
        except OptionError:  # too many joints for a search: the verdict does not know the distance either
            return True
        return nearest is None or nearest.distance > bar
