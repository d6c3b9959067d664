"""Parts of an explanation that are shown only on demand: ellipsoids, redundancy, coordinates of the orientation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import degrees, isinf

from rankdrop.results.explanation.data import ExplanationData
from rankdrop.results.explanation.words import fixed, power, short
from rankdrop.sections import Section


def ellipsoids_part(found: ExplanationData, full: bool) -> Iterator[Section]:
    """Velocity and force ellipsoids with their indices, for unit joint rates and for the velocity limits."""
    shapes = found.ellipsoids
    for group in (shapes.unit_rates, shapes.rate_limits):
        if group is None:
            continue
        parts = [part for part in (group.translation, group.rotation, group.task) if part is not None]
        rows = tuple(
            (part.name, _lengths(part.velocity.half_lengths), _lengths(part.force.half_lengths),
             *(short(index.value) for index in (part.sigma_min, part.condition, part.manipulability)))
            for part in parts
        )  # fmt: skip
        units = ", ".join(f"{part.name} {part.velocity.unit} and {part.force.unit}" for part in parts)
        yield Section(
            "Ellipsoids", group.ball, (),
            ("", "velocity half-axes", "force half-axes", "σ_min", "condition", "manipulability"), rows,
            texts=(0, 1, 2),
            notes=(f"units: {units}; the task as a whole takes {shapes.length_scale:.4g} m for 1 rad",),
        )  # fmt: skip


def redundancy_part(found: ExplanationData, full: bool) -> Iterator[Section]:
    """Null space, rank–nullity, both forms of the projector."""
    spare = found.redundancy
    lines = [
        f"rank {spare.check.rank} + nullity {spare.check.nullity} = {spare.check.n} joints: "
        + ("holds" if spare.check.holds else "DOES NOT HOLD"),
        f"projector I − J⁺J: ‖PP − P‖ ≤ {power(spare.idempotent)}, ‖JP‖ ≤ {power(spare.annihilates)}; "
        f"Jin's I − Jᵀ(JJᵀ)†J differs by at most {power(spare.difference)}",
    ]
    rows = tuple(tuple(fixed(value) for value in row) for row in spare.null_basis)
    columns = tuple(f"{number} {joint.name}" for number, joint in enumerate(found.robot.variables, start=1))
    title = "Joint motions that leave the task still"
    yield Section(title, "" if rows else "none", tuple(lines), columns if rows else (), rows, texts=(),
                  notes=("rows: joint rates [rad/s, m/s], to first order",) if rows else ())  # fmt: skip


def representation_part(found: ExplanationData, full: bool) -> Iterator[Section]:
    """Coordinates of the orientation and their own singularities."""
    every = found.representations
    rows = tuple(
        (one.name, ", ".join(f"{name} {short(value)}" for name, value in zip(one.names, one.coordinates, strict=True)),
         short(one.sigma_min), "none" if isinf(one.angle) else f"{degrees(one.angle):.3g}°",
         "SINGULAR" if one.singular else "near" if one.near else "")
        for one in (every.zyz, every.rpy, every.quaternion, every.rotvec)
    )  # fmt: skip
    yield Section("Coordinates of the orientation", every.words, (),
                  ("", "value [rad]", "σ_min of E", "nearest singularity", ""), rows, texts=(0, 1, 4))  # fmt: skip


def _lengths(values: Iterable[float]) -> str:
    return " ".join(short(round(float(value), 6)) for value in values)


DETAIL_PARTS: dict[str, Callable[[ExplanationData, bool], Iterator[Section]]] = {
    "ellipsoids": ellipsoids_part,
    "redundancy": redundancy_part,
    "representation": representation_part,
}
"""They by their names, in order."""
