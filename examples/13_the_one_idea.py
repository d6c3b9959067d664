"""The one idea, in NumPy.

The bracket differentiates the Jacobian, the block vanishes at a singularity. Together they drive an arm into a
singularity of any corank; no ties between singular values are in the way. See docs/mathematics.md.
"""

import numpy as np

import rankdrop

arm = rankdrop.open_robot("pa10")


def bracket(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """[A, B] = (ω_A × v_B + v_A × ω_B ; ω_A × ω_B), twists with the linear part first."""
    v, w = np.cross(a[3:], b[:3]) + np.cross(a[:3], b[3:]), np.cross(a[3:], b[3:])
    return np.concatenate([v, w])


def derivative(jacobian: np.ndarray) -> np.ndarray:
    """dJ[k] = ∂J/∂q_k: moving joint k carries every later screw along, and nothing else."""
    n = jacobian.shape[1]
    d = np.zeros((n, *jacobian.shape))
    for k in range(n):
        for i in range(k + 1, n):
            d[k][:, i] = bracket(jacobian[:, k], jacobian[:, i])
    return d


def drive(q: np.ndarray, rank: int) -> np.ndarray:
    """Levenberg-Marquardt on F = U₂ᵀ J V₂ with derivative D(Δ) = U₂ᵀ dJ(Δ) V₂."""
    damping, norm = 1e-2, np.inf
    for _ in range(100):
        J = rankdrop.jacobian(arm, q, rankdrop.Frame(axes=0, origin=0))  # screws about one fixed point
        u, sigma, vt = np.linalg.svd(J)
        u2, v2 = u[:, rank:], vt[rank:].T
        F, norm = (u2.T @ J @ v2).ravel(), np.linalg.norm(sigma[rank:])
        if norm < 1e-13:
            break
        D = np.stack([(u2.T @ dJ @ v2).ravel() for dJ in derivative(J)], axis=1)
        damping = min(damping, norm)
        q = q - np.linalg.solve(D.T @ D + damping**2 * np.eye(arm.n), D.T @ F)
    print(f"rank {rank}: σ beyond it below 1e-12: {norm < 1e-12}")
    return q


for rank in (5, 4, 3):
    q = drive(np.array([0.3, 0.4, 0.2, 0.5, -0.3, 0.6, 0.1]), rank)
    print("  q =", np.round(np.degrees(q), 2) + 0.0, "deg")
