"""The verdict on one configuration, and why."""

from __future__ import annotations

from rankdrop.local.verdict import Rank
from rankdrop.results.explanation.data import Far
from rankdrop.results.explanation.words import angle, angle_below, short
from rankdrop.tolerances import NEAR, SMALL


def verdict_of(rank: Rank, far: Far, near: float, small: float) -> tuple[str, str]:
    """The verdict and one sentence for it; see `rankdrop.explain.explain`."""
    r = rank.generic_rank
    sigma = float(rank.sigma[r - 1]) if r else 0.0
    lost = f"rank {rank.rank} of {r}"
    if rank.corank:
        times = "task freedom is" if rank.corank == 1 else "task freedoms are"
        return "singular", f"{lost}: {rank.corank} {times} lost{_nearly(rank, small)}"
    if rank.always_singular:
        return "always-singular", f"rank {r} here and at almost every configuration: the arm never does more"
    if far.near_miss is not None:
        least = f"σ{r} = {short(sigma, 3)} is small, but a descent from here ends at σ{r} = {short(far.near_miss, 3)}"
        return "near", f"{lost}; near miss: {least}, not at zero"
    if far.nearest is not None and far.nearest.distance <= near:
        there = f"a singular configuration is {angle(far.nearest.distance)} away"
        return "near", f"{lost}, but {there}{_several(rank, small)}"
    if sigma <= small:
        return "near", f"{lost}, but σ{r} = {short(sigma, 3)} is at most {short(small)}"
    if far.nearest is None:
        proven = f"none lies within {angle_below(far.certificate.radius)}" if far.certificate else "that is no proof"
        return "regular", f"{lost}; no singular configuration was found, and {proven}"
    return "regular", f"{lost}; the nearest singular configuration found is {angle(far.nearest.distance)} away"


def first_verdict(corank: int, generic_rank: int, smallest: int, sigma: float, distance: float, near: float = NEAR,
                  small: float = SMALL) -> str:  # fmt: skip
    """The verdict by what a monitor sees, before any search: near within the first-order distance.

    Args:
        corank: at the configuration.
        generic_rank: r.
        smallest: min(m, n) of the task and the arm.
        sigma: σ_r [1].
        distance: σ_r/‖∇σ_r‖ [rad].
        near, small: as in `rankdrop.explain.explain`.
    """
    if corank:
        return "singular"
    if generic_rank < smallest:
        return "always-singular"
    return "near" if distance <= near or sigma <= small else "regular"


def _several(rank: Rank, small: float) -> str:
    """Where more is small than what vanishes nearby: an arm without its offsets would lose it all."""
    count = int((rank.sigma[: rank.rank] <= small).sum())
    first = rank.rank - count
    return f"; {count} task freedoms are nearly lost, σ{first + 1} = {short(rank.sigma[first], 3)}" if count > 1 else ""


def _nearly(rank: Rank, small: float) -> str:
    """What is small beside what is zero: Gen3's offsets of 12 mm keep σ above zero where it would vanish without."""
    kept = rank.sigma[: rank.rank]
    return f", and σ{rank.rank} = {short(kept[-1], 3)} is nearly zero" if len(kept) and kept[-1] <= small else ""
