"""AM sections 1 and 2: the Jacobian and its derivative, gradients of singular values, ties, readable directions."""

from __future__ import annotations

from functools import cache
from math import comb, degrees

import numpy as np

from papers.item import Sheet, Shown, listed
from rankdrop.exact import derive, exact_chain
from rankdrop.families import refine
from rankdrop.kinematics import jacobian, jacobian_derivative, link_poses, pose, task_jacobian
from rankdrop.local import (
    decompose,
    gradient_tensor,
    lost_directions,
    null_space_motion,
    plane_rotation,
    readable_basis,
    sample,
    singular_values,
    spread,
    tied_gradients,
)
from rankdrop.robot import Array, Robot, open_robot
from rankdrop.task import SPACE, Frame, Task, resolve_task

H = 1e-6  # step of central differences [rad]: errors of about 1e-10
SMALL_ENTRY = 0.05  # of a direction; below it the motion is not named
DIFFERENCES = 1e-8  # agreement that central differences can show
BEFORE = """0 0 0  -0.27 0.62 -0.61  0.74 -0.17 -0.50  -0.50 -0.71 -0.50  -0.33 0.08 0.23  -0.12 0.28 -0.27"""
AFTER = """0 0 0  0 -0.91 0  0 0 0.91  -1 0 0  0 0 -0.41  0 -0.41 0"""
"""AM section 2.3: [u4 u5 u6] as the SVD gave them and after the rotation; rows vx vy vz wx wy wz."""
OFFSET = -0.45
"""Distance of the reference point from the line of the PA-10 that gives AM's numbers of section 2.3 [m]."""


def pa10() -> tuple[Robot, Task]:
    """AM's arm, 1 m counted as 1 rad, as AM do."""
    robot = open_robot("pa10")
    return robot, resolve_task("pose", robot, length_scale=1.0)


def introduction(sheet: Sheet) -> None:
    """Section 1."""
    sheet.numbers(
        "section 1", "determinants of sub-Jacobians of an 8-DoF manipulator", "28", comb(8, 6),
        reason="The number of ways to take 6 of 8 columns.",
    )  # fmt: skip
    robot = open_robot("canadarm2")
    minors = derive(exact_chain(robot), "cofactors", 20.0).sizes["minors"]
    q = sample(robot, resolve_task(None, robot), 50, 2)
    q[:, 3] = 0.0  # KG: of one choice of six joints the determinant is zero here, and the arm is not singular
    sizes = [np.abs([np.linalg.det(np.delete(J, j, axis=1)) for j in range(7)]) for J in jacobian(robot, q)]
    there = refine(robot, q, 1).q
    all_zero = max(abs(np.linalg.det(np.delete(J, j, axis=1))) for J in jacobian(robot, there) for j in range(7))
    one, most = max(float(row[0]) for row in sizes), min(float(row.max()) for row in sizes)
    sheet.claim(
        "section 1", "sub-Jacobian determinants of a 7-DoF manipulator that have to vanish together", "all of them (7)",
        f"{minors} minors of Canadarm2; at 50 singular configurations all vanish; where θ4 = 0 one of them does, "
        "and the arm is not singular",
        minors == comb(7, 6) and all_zero < 1e-6 and one < 1e-9 and most > 0.1,
    )  # fmt: skip


def singular(sheet: Sheet) -> None:
    """Sections 1 and 2.1: what holds at a singularity."""
    robot, task = pa10()
    q = np.array([0.3, 0.0, 0.5, 0.0, -0.7, 0.0, 0.5])  # row 2 of Table 4
    J, sigma = jacobian(robot, q), singular_values(robot, q, task)
    sheet.identity("section 1", "|J Jᵀ| at a singularity", "|J Jᵀ| = 0", float(abs(np.linalg.det(J @ J.T))))
    lost = lost_directions(robot, q, task, 2)
    sheet.identity("section 1", "power of a wrench along a lost direction on every column of J",
                   "a screw reciprocal to all columns", float(np.abs(lost @ J).max()))
    sheet.numbers("section 2.1", "singular values that are zero at a rank-2 singularity", "2",
                  int((sigma <= 1e-9).sum()), layout="n of them at a rank-n singularity")
    extra = [open_robot(name).n - resolve_task(None, open_robot(name)).m for name in ("pa10", "almarkhi4")]
    sheet.numbers("section 2.1", "degree of redundancy of the two robots, n − m", "1 1", extra, layout="n − m")


def background(sheet: Sheet) -> None:
    """Equations 1 to 8 and 10, at random configurations of the PA-10."""
    robot, task = pa10()
    rng = np.random.default_rng(0)
    q, rates = sample(robot, task, 1, 5)[0], rng.normal(size=robot.n)
    J = jacobian(robot, q)
    moved = [link_poses(robot, q + sign * H * rates)[-1] for sign in (1, -1)]
    turn = (moved[0][:3, :3] - moved[1][:3, :3]) @ pose(robot, q)[:3, :3].T / (2 * H)
    measured = [*((moved[0] - moved[1])[:3, 3] / (2 * H)), turn[2, 1], turn[0, 2], turn[1, 0]]
    sheet.identity("eq. 1", "ẋ = J θ̇, the twist of the tip by central differences", "ẋ = J θ̇",
                   float(np.abs(J @ rates - measured).max()), tolerance=DIFFERENCES)  # fmt: skip
    twist = rng.normal(size=6)
    found = null_space_motion(robot, q, twist, rates, task)
    sheet.identity("eq. 2", "J θ̇ for θ̇ = J⁺ẋ + n_J", "θ̇ = J⁺ẋ + n_J solves eq. 1",
                   float(np.abs(J @ found - twist).max()))  # fmt: skip
    parts = decompose(robot, q, task)
    rebuilt = parts.u * parts.sigma @ parts.v[:, :6].T
    sheet.identity("eq. 3", "sum of σ_i u_i v_iᵀ", "J = Σ σ_i u_i v_iᵀ", float(np.abs(rebuilt - J).max()))
    each = np.einsum("ai,ab,bi->i", parts.u, J, parts.v[:, :6])
    sheet.identity("eq. 4", "u_iᵀ J v_i", "σ_i = u_iᵀ J v_i", float(np.abs(each - parts.sigma).max()))
    dJ = jacobian_derivative(robot, q)
    sigma = [singular_values(robot, q + sign * H * rates, task) for sign in (1, -1)]
    rate = np.einsum("ai,abk,k,bi->i", parts.u, dJ, rates, parts.v[:, :6])
    error = float(np.abs(rate - (sigma[0] - sigma[1]) / (2 * H)).max())
    sheet.identity("eqs 5, 6", "the rate of every σ by central differences", "σ̇_i = u_iᵀ J̇ v_i", error,
                   tolerance=DIFFERENCES)  # fmt: skip
    _, tensor = gradient_tensor(robot, q, task, 3)
    differences = [singular_values(robot, q + H * e, task) - singular_values(robot, q - H * e, task) for e in np.eye(7)]
    error = float(np.abs(np.einsum("aan->an", tensor) - (np.array(differences) / (2 * H)).T[3:]).max())
    sheet.identity("eqs 7, 8, 10", "gradients of σ4, σ5, σ6 by central differences",
                   "∂σ_i/∂θ_k = u_iᵀ (∂J/∂θ_k) v_i", error, tolerance=DIFFERENCES)  # fmt: skip


def printed_derivative(robot: Robot, q: Array, *, corrected: bool) -> Array:
    """(6, n, n) AM eq. 9 at q, [:, i, k]; its last term for k < i as printed, p_k, or corrected, p_i."""
    J, n = jacobian(robot, q), robot.n
    lines = jacobian(robot, q, SPACE).T
    z = lines[:, 3:]
    points = np.cross(z, lines[:, :3])
    p = pose(robot, q)[:3, 3] - points
    found = np.zeros((6, n, n))
    for i in range(n):
        for k in range(n):
            if k < i:
                last = p[i] if corrected else p[k]
                found[:3, i, k] = (z[k] @ p[i]) * z[i] - (z[k] @ z[i]) * last
                found[3:, i, k] = np.cross(z[k], z[i])
            else:
                found[:3, i, k] = (z[i] @ p[k]) * z[k] - (z[k] @ z[i]) * p[k]
    assert np.allclose(J[3:], z.T)
    return found


def derivative_errors(name: str, count: int = 20) -> dict[str, float]:
    """Largest difference of eq. 9 from central differences: "printed" and "corrected" for k < i, "other" for k ≥ i, and
    of `jacobian_derivative`, "ours"."""
    robot = open_robot(name)
    task = resolve_task(None, robot)
    errors = dict.fromkeys(("printed", "corrected", "other", "ours"), 0.0)
    later = np.tril(np.ones((robot.n, robot.n), dtype=bool), -1)  # [i, k], k < i
    for q in sample(robot, task, count, 9):
        columns = [(jacobian(robot, q + H * e) - jacobian(robot, q - H * e)) / (2 * H) for e in np.eye(robot.n)]
        measured = np.stack(columns, axis=-1)
        for kind in ("printed", "corrected"):
            off = np.abs(printed_derivative(robot, q, corrected=kind == "corrected") - measured)
            errors[kind] = max(errors[kind], float(off[:, later].max()))
            errors["other"] = max(errors["other"], float(off[:, ~later].max()))
        errors["ours"] = max(errors["ours"], float(np.abs(jacobian_derivative(robot, q) - measured).max()))
    return errors


def equation_9(sheet: Sheet) -> None:
    """The derivative of a column of the Jacobian, each branch once, on both of AM's robots."""
    each = [derivative_errors(name) for name in ("almarkhi4", "pa10")]
    off = [errors["printed"] for errors in each]
    right = max(max(errors["corrected"], errors["ours"]) for errors in each)
    sheet.identity(
        "eq. 9", "branch k < i, on both robots, against central differences", "(z_k·p_i) z_i − (z_k·z_i) p_k",
        max(off), tolerance=DIFFERENCES, ours=f"off by up to {max(off):.1f}",
        reason="The last vector has to be p_i, as in (z_k·p_i) z_i − (z_k·z_i) p_i, "
        "since z_k × (z_i × p_i) is what the motion of joint k does.",
        shown=Shown(
            f"As printed it is off by up to {off[0]:.1f} (4-DoF robot) and {off[1]:.1f} (PA-10); corrected, and by "
            f"jacobian_derivative, it agrees with central differences to {DIFFERENCES:.0e}.",
            min(off) > 0.1 and right <= DIFFERENCES,
        ),
    )  # fmt: skip
    sheet.identity("eq. 9", "branch k ≥ i, on both robots, against central differences",
                   "(z_i·p_k) z_k − (z_k·z_i) p_k", max(errors["other"] for errors in each),
                   tolerance=DIFFERENCES)  # fmt: skip


@cache
def tied_places() -> tuple[tuple[Array, Array], ...]:
    """Configurations (7,) of the PA-10 with σ5 = σ6 > 0.05, and the tensor (2, 2, 7) of the two there (eq. 12)."""
    robot, task = pa10()
    found = []
    for start in sample(robot, task, 40, 4):
        q = start.copy()
        for _ in range(60):  # Newton on the two conditions of a tie: equal values, and no coupling
            sigma, tensor = gradient_tensor(robot, q, task, 4)
            gap = np.array([sigma[4] - sigma[5], 0.0])
            if gap[0] < 1e-12:
                break
            rows = np.array([tensor[0, 0] - tensor[1, 1], tensor[0, 1] + tensor[1, 0]])
            q = q - np.linalg.lstsq(rows, gap, rcond=None)[0] * min(1.0, 0.3 / max(gap[0], 1e-9))
        if sigma[4] - sigma[5] < 1e-9 and sigma[4] > 0.05:
            found.append((q, tensor))
    return tuple(found)


def ties(sheet: Sheet) -> None:
    """Equations 12 to 14."""
    robot, task = pa10()
    q, _ = tied_places()[0]
    J, parts = task_jacobian(robot, q, task), decompose(robot, q, task)
    turned = plane_rotation(2, 0, 1, 0.7)
    u, v = parts.u[:, 4:] @ turned, parts.v[:, 4:6] @ turned
    error = float(np.abs(np.einsum("ai,ab,bi->i", u, J, v) - parts.sigma[4:6]).max())
    sheet.identity("eq. 12", "turned vectors at σ5 = σ6: u_newᵀ J v_new = σ", "any vectors of the subspace are valid",
                   error, tolerance=DIFFERENCES)  # fmt: skip
    phis = np.linspace(0.0, np.pi, 361)
    turns = [plane_rotation(2, 0, 1, phi) for phi in phis]
    angles = np.array([[degrees(spread(tied_gradients(one, turn))) for turn in turns] for _, one in tied_places()])
    low, high = float(angles.min()), float(angles.max())
    full = int(((angles.min(axis=1) < 0.5) & (angles.max(axis=1) > 179.5)).sum())
    sheet.claim(
        "eq. 12", "range of the angle between ∇σ5 and ∇σ6 as φ goes from 0 to π", "can vary from 0 to π",
        f"from 0 to π at {full} of {len(angles)} ties of the PA-10; never below {low:.0f}° or above {high:.0f}°",
        full > 0, reason="The two gradients are A ± (B cos 2φ + C sin 2φ); A, B, C need not lie in a plane.",
        shown=Shown("Tried at every tie that 40 random starts lead to.", full == 0 and len(angles) > 10),
    )  # fmt: skip
    falls = [mixture_falls(one) for _, one in tied_places()]
    closest, others = np.array(falls).T
    held_up = int((closest < 0.0).sum())
    sheet.claim(
        "eqs 12, 13", "the rotation that brings the gradients closest, and a combination γ∇σ5 + (1 − γ)∇σ6 of them",
        "a combination that minimizes σ5 can be found",
        f"at {len(falls) - held_up} of {len(falls)} ties of the PA-10 there is a γ that lowers σ5; at {held_up} each γ "
        "raises it", held_up == 0,
        reason="Along the combination σ5 changes with the larger eigenvalue of the tied pair, to which their coupling "
        "u5ᵀ(∂J)v6 belongs as well; the angle between the gradients does not tell.",
        shown=Shown(f"Fall of σ5 per unit step with the best γ there: {listed(np.sort(closest)[:held_up], 3)}; with "
                    "another φ some combination lowers σ5 at every tie.",
                    held_up > 0 and closest.min() < -0.005 and others.min() > 0.005),
    )  # fmt: skip
    three = np.random.default_rng(6).normal(size=(3, 3, 7))
    gradients = tied_gradients(three, plane_rotation(3, 0, 2, 0.4))
    lengths = np.linalg.norm(gradients, axis=1)
    pairs = [(i, j) for i in range(3) for j in range(i + 1, 3)]
    summed = sum(float(np.arccos(gradients[i] @ gradients[j] / (lengths[i] * lengths[j]))) for i, j in pairs)
    sheet.identity("eq. 14", "H of three tied singular values, a sum of three angles", "H = Σ_i Σ_{j>i} θ_ij",
                   abs(spread(gradients) - summed))  # fmt: skip


def mixture_falls(tensor: Array) -> tuple[float, float]:
    """First-order fall of the larger of two tied singular values, per unit step down the best combination (eq. 13).

    Below zero where every combination raises it.

    Returns:
        With the rotation φ of smallest angle between the gradients (eq. 12), and with the best φ; γ from 0 to 1 in
        both.
    """
    turns = [plane_rotation(2, 0, 1, phi) for phi in np.linspace(0.0, np.pi, 181)]
    pairs = np.array([tied_gradients(tensor, turn) for turn in turns])  # (181, 2, 7)
    gamma = np.linspace(0.0, 1.0, 51)[:, None]
    downs = gamma * pairs[:, None, 0] + (1.0 - gamma) * pairs[:, None, 1]  # (181, 51, 7)
    downs /= np.linalg.norm(downs, axis=-1, keepdims=True)
    change = np.einsum("abn,pgn->pgab", (tensor + tensor.swapaxes(0, 1)) / 2, downs)
    best = np.linalg.eigvalsh(change)[..., 0].max(axis=1)
    return float(best[int(np.argmin([spread(pair) for pair in pairs]))]), float(best.max())


def directions(sheet: Sheet) -> None:
    """Section 2.3 and Figure 4: the 6 × 3 example."""
    before = np.array([float(word) for word in BEFORE.split()]).reshape(6, 3)
    printed = np.array([float(word) for word in AFTER.split()]).reshape(6, 3)
    found = matched(readable_basis(before), printed)
    sheet.numbers(
        "section 2.3", "the three rotated singular directions, from the printed ones (rows vx vy vz wx wy wz)",
        AFTER, found, reason="What goes in is printed to two digits. Order and signs of the columns are AM's.",
        half=0.005,
    )  # fmt: skip
    gram = before.T @ before
    sheet.numbers(
        "section 2.3", "lengths and products of the printed SVD vectors (11, 22, 33, 12, 13, 23)",
        "1.00 1.00 1.00 0.00 0.00 0.00", [*np.diag(gram), gram[0, 1], gram[0, 2], gram[1, 2]],
        reason="They are printed to two digits.",
    )  # fmt: skip
    directions_in_words(sheet, found)
    which_robot(sheet, printed)


def axes_of(column: Array) -> str:
    """The entries of (v; ω) that are not small, as motions along and about axes."""
    names = [f"{axis} {kind}" for kind in ("translation", "rotation") for axis in "XYZ"]
    large = zip(names, column, strict=True)
    return ", ".join(f"{'−' if value < 0 else ''}{name}" for name, value in large if abs(value) >= SMALL_ENTRY)


def directions_in_words(sheet: Sheet, found: Array) -> None:
    """What the text says of the three columns."""
    zero = np.abs(found) < SMALL_ENTRY
    sheet.claim("section 2.3", "first vector (green)", "rotation about −X", axes_of(found[:, 0]),
                bool((zero[:, 0] == [1, 1, 1, 0, 1, 1]).all() and found[3, 0] < 0))  # fmt: skip
    sheet.claim("section 2.3", "second vector (red)", "−Y translation with −Z rotation", axes_of(found[:, 1]),
                bool((zero[:, 1] == [1, 0, 1, 1, 1, 0]).all() and found[1, 1] < 0 and found[5, 1] < 0))  # fmt: skip
    is_as_said = bool((zero[:, 2] == [1, 0, 1, 1, 1, 0]).all())
    sheet.claim(
        "section 2.3", "third vector (blue)", "Y translation with −Z rotation", axes_of(found[:, 2]),
        is_as_said, reason="The text repeats the axes of the red vector; the printed column has others.",
        shown=Shown("Entries of the column: " + listed(found[:, 2], 2) + ".",
                    bool((zero[:, 2] == [1, 1, 0, 1, 0, 1]).all() and found[2, 2] > 0 and found[4, 2] < 0)),
    )  # fmt: skip


def offset_directions() -> Array:
    """(6, 3) what the PA-10 of Table 2 loses when stretched, the reference point 0.45 m aside of its line, towards −x.

    AM's X, Y, Z are x, y, z of the base there.
    """
    robot = open_robot("pa10")
    task = resolve_task("pose", robot, length_scale=1.0)
    aside = Task("pose", task.rows, Frame(0, -1, (OFFSET, 0.0, 0.0)), 1.0)
    return np.asarray(lost_directions(robot, np.zeros(7), aside, 3).T)


def which_robot(sheet: Sheet, printed: Array) -> None:
    """Which arm and point the example of section 2.3 belongs to."""
    robot, task = pa10()
    own = lost_directions(robot, np.zeros(7), task, 3)
    ours = np.linalg.svd(own[:, 3:], compute_uv=False)
    theirs = np.linalg.svd(printed[3:], compute_uv=False)
    found = offset_directions()
    sheet.claim(
        "section 2.3", "the 7-DoF robot of Figure 4: is it the PA-10 of Table 2, seen at its end effector?",
        "a 7-DoF robot in a rank-3 singularity (not named)",
        f"no: two of the PA-10's three lost motions are pure translations, none of the printed ones is "
        f"(rotation parts {listed(ours, 2)} against {listed(theirs, 2)})",
        bool((ours < 1e-9).sum() == 2 and theirs.min() > 0.3),
    )  # fmt: skip
    sheet.numbers(
        "section 2.3", f"the same, PA-10 stretched, reference point {abs(OFFSET)} m aside of its line", AFTER,
        matched(found, printed), half=0.005,
        reason="AM do not say where the point is: the distance is fitted, 0.41/0.91. It equals d7 of Table 2.",
    )  # fmt: skip


def matched(found: Array, printed: Array) -> Array:
    """Columns of `found` in the order and with the signs of the printed ones."""
    columns = []
    for column in printed.T:
        products = found.T @ column
        best = int(np.argmax(np.abs(products)))
        columns.append(found[:, best] * np.sign(products[best]))
    return np.stack(columns, axis=1)


SECTIONS = (
    ("introduction", introduction), ("singularities", singular), ("equations", background), ("equation 9", equation_9),
    ("ties", ties), ("directions", directions),
)  # fmt: skip

