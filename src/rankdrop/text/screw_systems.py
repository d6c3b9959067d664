"""Screw systems, and why an arm is singular at every configuration, in words."""

from __future__ import annotations

from rankdrop.local.axes import numbers
from rankdrop.local.screw_systems import AlwaysSingular, Loss, Members, ScrewSystem

_MEANING = {
    "coaxial": "one line",
    "translational": "slides",
    "cylindrical": "one line, turns and slides",
    "spherical": "axes that meet in one point",
    "planar": "parallel axes, slides normal to them",
    "planar with a screw": "parallel screws of one pitch, slides normal to them",
    "Schönflies": "parallel axes and slides",
}
"""What lies in each kind of system."""
_WHEN = {
    (False, False): "dependent here: no motion of these joints alone breaks it",
    (True, False): "at every configuration",
    (True, True): "dependent at every configuration",
}
"""Whether a system is structural, and permanent."""
_SHARED = {
    "coaxial": ("lie on one line", "lie on one line"),
    "translational 1": ("are parallel", "are parallel"),
    "translational 2": ("are parallel to one plane", "are parallel to one plane"),
    "translational 3": ("only translate", "only translate"),
    "cylindrical": ("lie on one line", "lie along one line"),
    "spherical": ("meet in one point", "meet in one point"),
    "planar": ("are parallel", "move in parallel planes"),
    "planar with a screw": ("move in parallel planes that rise by one pitch",) * 2,
    "Schönflies": ("are parallel", "turn about parallel axes and slide"),
}
"""What axes alone have in common in each kind of system, and joints with slides among them."""


def system_words(system: ScrewSystem) -> str:
    """What the joints of a system have in common, and whether they are dependent."""
    joints = numbers([number - 1 for number in system.numbers])
    shared = f"{system.members} {joints} {_common_geometry_words(system)}"
    when = _WHEN[system.structural, system.permanent]
    return f"{shared} ({system.kind} system of dimension {system.dimension}), {when}"


def _common_geometry_words(system: ScrewSystem) -> str:
    """What the joints have in common: "are parallel"."""
    if system.kind == "translational":
        of_axes, with_slides = _SHARED[f"{system.kind} {system.dimension}"]
    else:
        of_axes, with_slides = _SHARED[system.kind]
    if system.members is Members.AXES:
        return of_axes
    return with_slides


def always_singular_words(always_singular: AlwaysSingular) -> str:
    """The rank, and the systems that account for it."""
    return f"rank {always_singular.rank} of {always_singular.most} everywhere: {_reason(always_singular)}"


def _reason(always_singular: AlwaysSingular) -> str:
    if always_singular.dimension:
        return _all_inside(always_singular)
    if not always_singular.losses:
        return "no screw system of the joints accounts for it"
    words = "; ".join(map(_loss_words, always_singular.losses))
    if always_singular.bound > always_singular.rank:
        words += f"; this accounts for rank {always_singular.bound}, not for {always_singular.rank}"
    return words


def _all_inside(always_singular: AlwaysSingular) -> str:
    """All joints in one subgroup, and what the task sees of it."""
    if always_singular.kind:
        system = f"a {always_singular.kind} system ({_MEANING[always_singular.kind]})"
    else:
        system = "a system"
    words = f"joints {numbers(range(always_singular.joints))} lie in {system} of dimension {always_singular.dimension}"
    if always_singular.dimension == always_singular.rank:
        return words
    return f"{words}, of which this task sees {always_singular.rank}"


def _loss_words(loss: Loss) -> str:
    joints = numbers(sorted(loss.joints))
    if not loss.kind:
        return f"joint {joints} moves nothing in this task"
    return f"joints {joints} lie in a {loss.kind} system of dimension {loss.dimension} and lose {loss.lost}"
