"""Singularities of coordinates of the orientation, in words."""

from __future__ import annotations

from rankdrop.local.orientation import NAMES, Representation, Representations

_STATES = {
    (True, False): "singular here: a matter of coordinates, not of the arm",
    (False, True): "near a singularity of theirs: their rates are large, not the arm's",
    (False, False): "regular here",
}
"""Whether coordinates are singular, and near a singularity of theirs."""
_SINGULAR = {
    (False, False): "neither the arm nor any of the coordinates is singular",
    (False, True): "only the coordinates {} are singular; the arm moves freely: use the quaternion",
    (True, False): "the arm is singular for the whole pose; no coordinates are",
    (True, True): "the arm is singular for the whole pose, and so are the coordinates {}",
}
"""Whether the arm is singular, and whether some coordinates are."""


def representation_words(representation: Representation) -> str:
    """Whether coordinates are singular at a pose, or near a singularity."""
    if representation.name == "quaternion":
        return "a quaternion has no singularity"
    return f"{representation.name} coordinates are {_STATES[representation.singular, representation.near]}"


def representations_words(representations: Representations) -> str:
    """What is singular at a configuration: the arm, coordinates, both or neither."""
    by_name = {representation.name: representation.singular for representation in representations.every}
    singular = ", ".join(name for name in NAMES if by_name[name])
    return _SINGULAR[representations.arm.corank > 0, singular != ""].format(singular)
