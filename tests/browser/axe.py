"""axe-core in the headless Chromium: contrast, names, roles and keyboard operation of a page.

The rules come with the package axe-playwright-python (extra `browser`); no browser of Playwright's own is needed.
"""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path

import pytest

from browser.chromium import Browser

RULES = ("wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice")


def axe_program() -> str:
    """The program of axe-core; skips the test where the package is not installed."""
    found = find_spec("axe_playwright_python")
    if found is None or found.origin is None:
        pytest.skip("axe-playwright-python (extra `browser`) is not installed")
    return (Path(found.origin).parent / "axe.min.js").read_text(encoding="utf-8")


def violations(browser: Browser, leave: tuple[str, ...] = ()) -> list[str]:
    """What axe-core finds wrong with the page that is open: rule, how bad, and the first places.

    Args:
        browser: with a page.
        leave: rules that are not asked for.
    """
    browser.run(f"(() => {{ {axe_program()} ; return true; }})()")
    rules = json.dumps({"runOnly": list(RULES), "rules": {one: {"enabled": False} for one in leave}})
    found = browser.run(f"axe.run(document, {rules}).then((r) => r.violations)")
    return [
        f"{one['id']} ({one['impact']}): {one['help']}: "
        + "; ".join(f"{node['html'][:160]} {node.get('failureSummary', '')[:220]}" for node in one["nodes"][:4])
        for one in found
    ]
