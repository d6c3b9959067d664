"""Write the atlases that are shipped: one JSON file for each arm of the catalogue, and the index of their fingerprints.

    .venv/bin/python tools/make_atlases.py            # all arms, about two minutes
    .venv/bin/python tools/make_atlases.py pa10 ur5   # these, and the index anew

An atlas in which some fresh point is unexplained, a row unsound or a family unnamed is not written.
They hold no exact conditions: what these say in addition is text, and derived anew in seconds where it is wanted.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from rankdrop.analyze import analyze
from rankdrop.known import INDEX, SEED, STARTS
from rankdrop.robot.fingerprint import coarse_fingerprint
from rankdrop.robot.open import open_robot, robot_names

FOLDER = Path(__file__).resolve().parents[1] / "src" / "rankdrop" / "atlases"


def write(name: str) -> None:
    """Analyse one arm and write its file."""
    found = analyze(open_robot(name), starts=STARTS, seed=SEED, exact="off")
    if not (found.complete and found.verified and found.residual().holds(found.settings.tolerances)):
        raise SystemExit(f"{name}: the analysis is not verified; nothing was written")
    text = json.dumps(found.to_dict(), ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    (FOLDER / f"{name}.json").write_text(text + "\n", encoding="utf-8")
    print(f"{name}: {len(found.families)} families, {len(text) / 1000:.0f} kB", flush=True)


def write_index() -> None:
    """Fingerprint -> names, of all files that are there."""
    index: dict[str, list[str]] = {}
    for path in sorted(FOLDER.glob("*.json")):
        if path.name != INDEX:
            index.setdefault(coarse_fingerprint(open_robot(path.stem)), []).append(path.stem)
    (FOLDER / INDEX).write_text(json.dumps(index, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for arm in sys.argv[1:] or robot_names():
        write(arm)
    write_index()
