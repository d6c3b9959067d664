"""The Jacobian in the axes of a link as a result: code of its inverse, checks, and which matrices have an inverse."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rankdrop.results.jacobian_in_frame import CheckKind, regular
from rankdrop.robot.open import open_robot
from rankdrop.tolerances import DEFAULT
from rankdrop.verbs.jacobian_in_frame import link_jacobian

Q = (0.4, 1.1)


def test_a_matrix_is_regular_whatever_its_unit(rng: np.random.Generator) -> None:
    turn = np.linalg.qr(rng.normal(size=(4, 4)))[0]
    for least, has_inverse in ((2 * DEFAULT.singular, True), (0.5 * DEFAULT.singular, False)):
        for unit in (1e-6, 1.0, 1e6):
            assert regular(unit * turn @ np.diag([1.0, 0.1, 0.1, least])) is has_inverse


def test_the_code_of_the_inverse_gives_the_inverse_of_the_numbers() -> None:
    found = link_jacobian(open_robot("planar2r"), 1, inverse=True, q=Q)
    names = {f"q{j}": value for j, value in enumerate(Q, start=1)} | dict(found.letters)
    names |= {"sin": np.sin, "cos": np.cos}
    values = [[eval(entry.code(code), names) for entry, code in row] for row in found.inverse_code]
    assert found.numbers is not None
    assert np.array(values) @ found.numbers.matrix == pytest.approx(np.eye(2), abs=1e-12)
    assert found.numbers.inverse == pytest.approx(np.array(values))


def test_without_an_inverse_there_is_no_code_of_it() -> None:
    assert link_jacobian(open_robot("planar2r"), 1).inverse_code == []


def test_one_check_that_fails_is_enough() -> None:
    found = link_jacobian(open_robot("planar2r"), 1, inverse=True, q=Q)
    assert {check.kind for check in found.checks} >= {CheckKind.CLOSED_FORM, CheckKind.ADJUGATE}
    assert found.holds
    for k, check in enumerate(found.checks):
        failed = replace(check, holds=False)
        assert not replace(found, checks=(*found.checks[:k], failed, *found.checks[k + 1 :])).holds
