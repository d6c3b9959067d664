"""Three turning joints that move a point, in plain NumPy: inverse by Pieper's quartic, aspects by flooding a grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def turned(a: float, alpha: float, d: float, theta: Array, p: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
    """Rz(θ) Tz(d) Tx(a) Rx(α) p."""
    x, y, z = a + p[0], np.cos(alpha) * p[1] - np.sin(alpha) * p[2], np.sin(alpha) * p[1] + np.cos(alpha) * p[2]
    return np.cos(theta) * x - np.sin(theta) * y, np.sin(theta) * x + np.cos(theta) * y, z + d


def point(rows: Array, theta2: Array, theta3: Array) -> tuple[Array, Array, Array]:
    """The point in the frame of link 1 at θ1 = 0; rows (3, 3) of (d, a, α), the point at the end of the third."""
    zero = np.zeros(np.broadcast(theta2, theta3).shape)
    p = turned(rows[2, 1], rows[2, 2], rows[2, 0], theta3 + zero, (zero, zero, zero))
    p = turned(rows[1, 1], rows[1, 2], rows[1, 0], theta2 + zero, p)
    return turned(rows[0, 1], rows[0, 2], 0.0, zero, p)


def image(rows: Array, theta2: Array, theta3: Array) -> tuple[Array, Array]:
    """(|p|², p·z₁) of the point."""
    x, y, z = point(rows, np.asarray(theta2), np.asarray(theta3))
    return x * x + y * y + z * z, z


def inverse(rows: Array, f: float, g: float) -> Array:
    """(k, 2) all (θ2, θ3) with this image, by the quartic in tan(θ3/2); sin α1 and a1 not zero.

    f = F3 + 2 a1 (k1 c2 + k2 s2), g = F4 + sin α1 (k1 s2 − k2 c2): the squares of k1 c2 + k2 s2 and k1 s2 − k2 c2 sum
    up to k1² + k2². Each of k1, k2, F3, F4 is linear in cos θ3, sin θ3.
    """
    a1, sine = rows[0, 1], np.sin(rows[0, 2])
    angles = np.linspace(0.0, 2 * np.pi, 11)[:-1]
    # values at θ2 = 0, π/2, π give the parts as functions of θ3
    (f0, g0), (f1, _), (f2, g2) = (image(rows, np.full(10, t), angles) for t in (0.0, np.pi / 2, np.pi))
    middle_f, middle_g = 0.5 * (f0 + f2), 0.5 * (g0 + g2)
    k1, k2 = 0.5 * (f0 - f2) / (2 * a1), (f1 - middle_f) / (2 * a1)
    value = ((f - middle_f) / (2 * a1)) ** 2 + ((g - middle_g) / sine) ** 2 - k1**2 - k2**2
    basis = np.stack([np.ones(10), np.cos(angles), np.sin(angles), np.cos(2 * angles), np.sin(2 * angles)], axis=1)
    c0, c1, s1, c2, s2 = np.linalg.lstsq(basis, value, rcond=None)[0]
    one, cos, sin = np.array([1.0, 0, 1]), np.array([-1.0, 0, 1]), np.array([0, 2.0, 0])  # highest power first
    quartic = np.zeros(5)
    quartic += c0 * np.polymul(one, one)
    quartic += np.pad(c1 * np.polymul(cos, one), (5 - len(np.polymul(cos, one)), 0))
    quartic += np.pad(s1 * np.polymul(sin, one), (5 - len(np.polymul(sin, one)), 0))
    square = np.polymul(cos, cos) - np.pad(np.polymul(sin, sin), (5 - len(np.polymul(sin, sin)), 0))
    quartic += c2 * square
    quartic += np.pad(2 * s2 * np.polymul(sin, cos), (5 - len(np.polymul(sin, cos)), 0))
    found = []
    for root in np.roots(quartic):
        if abs(root.imag) > 1e-7:
            continue
        theta3 = 2 * np.arctan(root.real)
        (p0, h0), (p1, _), (p2, h2) = (image(rows, np.array(t), np.array(theta3)) for t in (0.0, np.pi / 2, np.pi))
        u, v = 0.5 * (p0 - p2) / (2 * a1), (p1 - 0.5 * (p0 + p2)) / (2 * a1)
        along, across = (f - 0.5 * (p0 + p2)) / (2 * a1), (g - 0.5 * (h0 + h2)) / sine
        # along = u c + v s, across = ±(u s − v c): the sign that the arm has
        for sign in (1.0, -1.0):
            theta2 = np.arctan2(v * along + sign * u * across, u * along - sign * v * across)
            back = image(rows, np.array(theta2), np.array(theta3))
            if abs(back[0] - f) + abs(back[1] - g) < 1e-6:
                found.append((float(theta2), float(theta3)))
                break
    return np.array(found).reshape(-1, 2)


def determinant(rows: Array, theta2: Array, theta3: Array) -> Array:
    """∂(f, g)/∂(θ2, θ3) by central differences."""
    h = 1e-6
    up2, down2 = image(rows, theta2 + h, theta3), image(rows, theta2 - h, theta3)
    up3, down3 = image(rows, theta2, theta3 + h), image(rows, theta2, theta3 - h)
    f2, g2, f3, g3 = (up2[0] - down2[0], up2[1] - down2[1], up3[0] - down3[0], up3[1] - down3[1])
    return (f2 * g3 - g2 * f3) / (4 * h * h)


def flooded(rows: Array, count: int) -> NDArray[np.int64]:
    """(count, count) labels of the torus: nodes of one sign of the determinant that neighbours join share one."""
    at = (np.arange(count) + 0.5) * 2 * np.pi / count
    positive = determinant(rows, at[:, None], at[None, :]) > 0
    labels = np.arange(count * count).reshape(count, count)
    while True:
        before = labels
        for axis in (0, 1):
            for step in (1, -1):
                same = positive == np.roll(positive, step, axis=axis)
                labels = np.where(same, np.minimum(labels, np.roll(labels, step, axis=axis)), labels)
        labels = labels.ravel()[labels]  # whose label is mine: path doubling
        if np.array_equal(labels, before):
            return labels


def aspect(labels: NDArray[np.int64], theta: Array) -> NDArray[np.int64]:
    """Labels of (k, 2) angles: those of the node nearest to each."""
    count = len(labels)
    index = np.floor(theta % (2 * np.pi) * count / (2 * np.pi)).astype(int) % count
    return labels[index[:, 0], index[:, 1]]


def node(count: int, theta: Array) -> Array:
    """(k, 2) angles of the node nearest to each."""
    return (np.floor(theta % (2 * np.pi) * count / (2 * np.pi)) + 0.5) * 2 * np.pi / count
