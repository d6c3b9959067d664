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


FAINT = """(least) => {
    const parts = (text) => { const all = (text.match(/[\\d.]+/g) || []).map(Number); return [...all, 1].slice(0, 4); };
    const over = (ink, paper) => paper.map((value, i) => ink[i] * ink[3] + value * (1 - ink[3]));
    const linear = (value) => value <= 10.3 ? value / 3294.6 : ((value / 255 + 0.055) / 1.055) ** 2.4;
    const light = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
    const found = [], texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (texts.nextNode()) {
        const text = texts.currentNode.textContent.trim(), holder = texts.currentNode.parentElement;
        const out = "script, style, [aria-hidden=true], [data-disabled], :disabled";
        if (!/[\\p{L}\\p{N}]/u.test(text) || holder.closest(out)) continue;
        if (!holder.checkVisibility({ checkVisibilityCSS: true, checkOpacity: true })) continue;
        const papers = [];
        let faded = 1;
        for (let one = holder; one; one = one.parentElement) {
            const style = getComputedStyle(one), paper = parts(style.backgroundColor);
            faded *= Number(style.opacity);
            papers.unshift(paper);
            if (paper[3] === 1) break;
        }
        const paper = papers.reduce((below, one) => over(one, below), [255, 255, 255]);
        const ink = parts(getComputedStyle(holder).color);
        const ends = [light(over([...ink.slice(0, 3), ink[3] * faded], paper)), light(paper)].sort((a, b) => b - a);
        const contrast = (ends[0] + 0.05) / (ends[1] + 0.05);
        if (contrast < least) found.push([text, Number(contrast.toFixed(2))]);
    }
    return found;
}"""
"""Texts of a page whose contrast is below a bound (4.5 of WCAG AA), also where axe cannot tell: over a canvas."""
