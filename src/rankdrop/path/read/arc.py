"""The circular arc of a program's move: through a place on the way, from one pose to another.

The tip goes on the circle through three places; the tool turns about one axis in proportion to the way, as it does on a
straight line. Poses along the arc are so close that its chords leave it by a given height at most: s = r (1 − cos δ/2)
for chords of an angle δ.
"""

from __future__ import annotations

from math import acos, atan2, ceil, pi

import numpy as np

from rankdrop.local.orientation import rotation_vector
from rankdrop.poses.inverse import rotation
from rankdrop.robot.model import Array

_ON_A_LINE = 1e-6  # sine of the angle at the place on the way below which the three are on one line
_MOST_CHORDS = 20_000
_LONGEST = pi  # the tool is turned about the axis of a longer arc the other way round
_SAME_TURN = 1e-4  # entries of rotations that are one


def arc_poses(begin: Array, via: Array, end: Array, height: float) -> Array | None:
    """Poses along an arc; None where its three places are on one line, or two of them are one.

    Args:
        begin, end: (4, 4).
        via: (3,) a place on the arc between them.
        height: by which chords may leave the arc [m].

    Returns:
        (K, 4, 4) poses at equal angles, the first and the last as given.

    Example:
        >>> there = np.eye(4)
        >>> there[:3, 3] = [2.0, 0.0, 0.0]
        >>> arc_poses(np.eye(4), np.array([1.0, 1.0, 0.0]), there, 0.1)[:, :3, 3].round(3) + 0.0
        array([[0.   , 0.   , 0.   ],
               [0.293, 0.707, 0.   ],
               [1.   , 1.   , 0.   ],
               [1.707, 0.707, 0.   ],
               [2.   , 0.   , 0.   ]])
    """
    circle = _circle(begin[:3, 3], via, end[:3, 3])
    if circle is None:
        return None
    centre, axis, angle = circle
    out = begin[:3, 3] - centre
    radius = float(np.linalg.norm(out))
    chord = 2.0 * acos(max(1.0 - height / radius, -1.0))
    count = min(max(ceil(angle / chord), 2), _MOST_CHORDS)
    share = np.linspace(0.0, 1.0, count + 1)
    along = np.cross(axis, out)
    cosine, sine = np.cos(angle * share)[:, None], np.sin(angle * share)[:, None]
    turn = rotation_vector((end[:3, :3] @ begin[:3, :3].T)[None])[0]
    poses = np.tile(np.eye(4), (count + 1, 1, 1))
    poses[:, :3, 3] = centre + cosine * out + sine * along
    poses[:, :3, :3] = rotation(share[:, None] * turn) @ begin[:3, :3]
    poses[0], poses[-1] = begin, end
    return poses


def same_turn(first: Array, second: Array) -> bool:
    """Whether two poses (4, 4) have one orientation."""
    return bool(np.abs(second[:3, :3] - first[:3, :3]).max() <= _SAME_TURN)


def arc_angle(begin: Array, via: Array, end: Array) -> float | None:
    """The angle of the arc through three places (3,) [rad]; None where they are on one line."""
    circle = _circle(begin, via, end)
    if circle is None:
        return None
    return circle[2]


def _circle(begin: Array, via: Array, end: Array) -> tuple[Array, Array, float] | None:
    """Centre, axis and angle in (0, 2π) of the arc through three places (3,); None where they are on one line.

    With a = begin − via and b = end − via the centre is via + ((|a|² b − |b|² a) × (a × b)) / (2 |a × b|²).
    """
    a, b = begin - via, end - via
    across = np.cross(a, b)
    size = float(np.linalg.norm(across))
    if size <= _ON_A_LINE * float(np.linalg.norm(a) * np.linalg.norm(b)):
        return None
    centre = via + np.cross((a @ a) * b - (b @ b) * a, across) / (2.0 * size**2)
    out = begin - centre
    axis = -across / size
    along = np.cross(axis, out)
    to_via, to_end = (_angle(place - centre, out, along) for place in (via, end))
    if to_via > to_end:
        return centre, -axis, 2.0 * pi - to_end
    return centre, axis, to_end


def _angle(place: Array, out: Array, along: Array) -> float:
    """The angle in [0, 2π) of a place (3,) seen from the centre, from one direction of the plane towards another."""
    return atan2(float(place @ along), float(place @ out)) % (2.0 * pi)


def place_between(begin: Array, via: Array, end: Array) -> Array | None:
    """The place (3,) on the way of an arc on which the tool keeps its orientation, whatever the settings are.

    None where it turns from one end (4, 4) to the other, or the arc is longer than half a turn.
    """
    angle = arc_angle(begin[:3, 3], via, end[:3, 3])
    if angle is None or angle > _LONGEST or not same_turn(begin, end):
        return None
    return np.asarray(via)
