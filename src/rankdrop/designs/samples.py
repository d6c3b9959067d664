"""The variants of a sweep: one row of parameter values each, in an order in which neighbours follow each other.

A grid is walked like a field is ploughed: every step changes one parameter by one value. Samples fill the box of the
ranges: Latin hypercube and Sobol by scipy.stats.qmc, scrambled by the seed, in the order of their first parameter cut
into strips. Variants that follow each other share what is known of their families (`rankdrop.families.memory`).
"""

from __future__ import annotations

from math import ceil, sqrt
from typing import Any

import numpy as np

from rankdrop.designs.spec import Parameter, Spec
from rankdrop.errors import MissingExtraError
from rankdrop.robot.model import Array


def variants_of(spec: Spec) -> Array:
    """(V, p) parameter values of every variant [m, rad], numbered as a user counts them.

    A grid has its first parameter slowest; a list is as it was given; samples are as they were drawn.

    Raises:
        MissingExtraError: a sample, and scipy is not installed.
    """
    if spec.kind == "list":
        return np.array(spec.listed, dtype=np.float64)
    if spec.kind == "grid":
        axes = np.meshgrid(*(one.values for one in spec.parameters), indexing="ij")
        return np.stack([axis.reshape(-1) for axis in axes], axis=1)
    qmc, count = _qmc(), len(spec.parameters)
    if spec.kind == "latin-hypercube":
        unit = qmc.LatinHypercube(count, rng=spec.seed).random(spec.count)
    else:
        unit = qmc.Sobol(count, rng=spec.seed).random_base2(ceil(np.log2(spec.count)))
    low, high = box(spec.parameters)
    return np.asarray(low + unit[: spec.count] * (high - low))


def _qmc() -> Any:
    try:
        from scipy.stats import qmc
    except ImportError as error:
        raise MissingExtraError("scipy", "sweep", "a Latin hypercube or Sobol sample") from error
    return qmc


def box(parameters: tuple[Parameter, ...]) -> tuple[Array, Array]:
    """Lower and upper corner (p,) of the ranges [m, rad]."""
    return np.array([one.lower for one in parameters]), np.array([one.upper for one in parameters])


def order_of(spec: Spec, values: Array) -> list[int]:
    """The variants in the order in which they are made: each near the one before."""
    if spec.kind == "list":
        return list(range(len(values)))
    if spec.kind == "grid":
        return _ploughed([len(one.values) for one in spec.parameters])
    low, high = box(spec.parameters)
    unit = (values - low) / np.where(high > low, high - low, 1.0)
    strips = max(1, round(sqrt(len(values) / 4)))
    strip = np.minimum((unit[:, 0] * strips).astype(int), strips - 1)
    second = unit[:, 1] if unit.shape[1] > 1 else unit[:, 0]
    along = np.where(strip % 2 == 0, second, 1.0 - second)
    return [int(i) for i in np.lexsort((np.arange(len(values)), along, strip))]


def _ploughed(counts: list[int]) -> list[int]:
    """Indices into the grid (first axis slowest), every second row backwards."""
    order = [0]
    for count in counts:
        walked = []
        for place, index in enumerate(order):
            steps = range(count) if place % 2 == 0 else range(count - 1, -1, -1)
            walked += [index * count + step for step in steps]
        order = walked
    return order
