"""One version: of the package, of what is installed, and in every result."""

from __future__ import annotations

import importlib.metadata
import runpy

import pytest

import rankdrop
from rankdrop import version as module
from rankdrop.jobs import running
from rankdrop.robot.open import open_robot


def test_the_package_has_the_version_that_is_installed() -> None:
    assert importlib.metadata.version("rankdrop") == module.VERSION
    assert rankdrop.__version__ == module.VERSION


def test_results_and_jobs_record_it() -> None:
    assert running.VERSION == module.VERSION
    checked = rankdrop.check_path(open_robot("planar2r"), [[0.1, 0.4], [0.2, 0.5]]).to_dict()
    assert module.VERSION in str(checked)


def test_a_source_tree_that_is_not_installed_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> str:
        assert name == "rankdrop"
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "version", missing)
    alone = runpy.run_path(str(module.__file__))
    assert alone["VERSION"] == alone["__version__"] == "0+unknown"
