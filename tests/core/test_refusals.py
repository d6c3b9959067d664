"""What the core refuses, in place of reading what is not there; and matrices of any size a double can have."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from reference import arms

from rankdrop import _core
from rankdrop.kinematics import chain_of, task_view
from rankdrop.local.directions import readable_bases
from rankdrop.robot.model import Array
from rankdrop.task import resolve_task

EPS = float(np.finfo(float).eps)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("columns", [1, 2, 3, 5])
def test_a_basis_that_is_not_finite_is_refused(bad: float, columns: int, rng: np.random.Generator) -> None:
    bases = np.linalg.qr(rng.normal(size=(4, 6, columns)))[0]
    readable_bases(bases)
    bases[2, 3, columns - 1] = bad
    with pytest.raises(ValueError, match="orthonormal"):
        readable_bases(bases)


@pytest.mark.parametrize("columns", [2, 3, 4])
def test_columns_that_are_not_orthonormal_are_refused(columns: int) -> None:
    """Zero columns have no plane rotation at all: there was nothing to choose from."""
    with pytest.raises(ValueError, match="orthonormal"):
        readable_bases(np.zeros((1, 6, columns)))
    with pytest.raises(ValueError, match="orthonormal"):
        readable_bases(np.ones((1, 6, columns)))


def view_of(links: dict[str, int]) -> _core.View:
    chain = chain_of(arms.pa10())
    return _core.make_view(
        chain, point=[0.0] * 3, rows=[0, 1], factors=[1.0, 1.0], **({"axes": 0, "origin": 0} | links)
    )


@pytest.mark.parametrize("which", ["axes", "origin"])
def test_a_view_from_a_link_that_is_not_there_is_refused(which: str) -> None:
    view_of({which: 0}), view_of({which: 8})
    for link in (-1, 9, 2**31 - 1):
        with pytest.raises(ValueError, match="no such link"):
            view_of({which: link})


def test_a_view_of_another_chain_is_refused() -> None:
    view = view_of({"axes": 8})
    robot = arms.puma()
    puma = chain_of(robot)
    for function in (_core.jacobian, _core.derivative, _core.singular_values, _core.decompose):
        with pytest.raises(ValueError, match="another number of links"):
            function(puma, view, np.zeros((2, 6)))
    with pytest.raises(ValueError, match="another number of links"):
        _core.jacobian_one(robot, np.zeros(6), None, view)


def settings(**changed: Any) -> _core.SearchSettings:
    told: dict[str, Any] = {
        "method": 0, "rank": 5, "iterations": 20, "singular": 1e-9, "target": 1e-13, "stationary": 1e-5, "seed": 0,
        "scale": np.ones(7), "limits": None, "tie": 1e-2,
    }  # fmt: skip
    return _core.SearchSettings(**(told | changed))


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"method": 3}, "method"),
        ({"method": -1}, "method"),
        ({"iterations": -1}, "iterations"),
        ({"iterations": 2**31 - 1}, "iterations"),
        ({"rank": 6}, "rank"),
        ({"rank": -1}, "rank"),
        ({"scale": np.ones(6)}, "scale"),
        ({"limits": np.zeros((2, 6))}, "limits"),
        ({"limits": np.zeros((3, 7))}, "limits"),
    ],
)
def test_settings_of_a_search_that_do_not_fit_are_refused(wrong: dict[str, Any], words: str) -> None:
    robot = arms.pa10()
    chain, view = chain_of(robot), task_view(robot, resolve_task("pose", robot))
    _core.search(chain, view, np.zeros((2, 7)), settings())
    with pytest.raises(ValueError, match=words):
        _core.search(chain, view, np.zeros((2, 7)), settings(**wrong))


def test_limits_may_be_let_go_of_before_the_search() -> None:
    """The core keeps a copy: a converted array that is gone was read before."""
    robot = arms.pa10()
    chain, view = chain_of(robot), task_view(robot, resolve_task("pose", robot))
    starts = np.random.default_rng(0).uniform(-1, 1, (50, 7))
    box = np.array([[-1.0] * 7, [1.0] * 7])
    want = _core.search(chain, view, starts, settings(limits=box))[0]
    lost = settings(limits=box.astype(np.float32))
    junk = [np.full((2, 7), 1e300) for _ in range(200)]
    np.testing.assert_array_equal(_core.search(chain, view, starts, lost)[0], want)
    assert len(junk) == 200


@pytest.mark.parametrize("shape", [(6, 7), (7, 6), (3, 3), (2, 5), (1, 4)])
@pytest.mark.parametrize("exponent", [-1000, -600, -531, 531, 600, 1000])
def test_singular_values_of_huge_and_tiny_matrices(
    shape: tuple[int, int], exponent: int, rng: np.random.Generator
) -> None:
    """Multiplied by a power of two, a matrix keeps every digit of U and V, and σ is multiplied."""
    batch = rng.normal(size=(21, *shape))
    batch[3] = 0.0
    u, sigma, v = _core.svd(batch)
    far_u, far, far_v = _core.svd(np.ldexp(batch, exponent))
    np.testing.assert_array_equal(far, np.ldexp(sigma, exponent))
    np.testing.assert_array_equal(far_u, u)
    np.testing.assert_array_equal(far_v, v)


@pytest.mark.parametrize("size", [1e-300, 1e-160, 1e160, 1e300])
def test_singular_values_at_the_ends_of_the_range(size: float, rng: np.random.Generator) -> None:
    batch: Array = rng.normal(size=(20, 6, 7))
    want = np.linalg.svd(batch, compute_uv=False)
    assert (np.abs(_core.svd(batch * size, False) / size - want) <= 16 * EPS * want[:, :1]).all()


def test_a_matrix_does_not_mind_its_neighbours(rng: np.random.Generator) -> None:
    batch = rng.normal(size=(8, 6, 7))
    alone = _core.svd(batch, False)
    mixed = np.concatenate([batch, batch * 1e200, batch * 1e-200])[np.arange(24).reshape(3, 8).T.reshape(-1)]
    np.testing.assert_array_equal(_core.svd(mixed, False)[::3], alone)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("vectors", [True, False])
def test_a_matrix_that_is_not_finite_has_no_singular_values(bad: float, vectors: bool) -> None:
    """Five of six values came out as numbers, smaller than they could be."""
    batch = np.ones((9, 6, 7))
    _core.svd(batch, vectors)
    batch[8, 5, 6] = bad
    with pytest.raises(ValueError, match="finite"):
        _core.svd(batch, vectors)
