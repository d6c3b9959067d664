"""Save one result of every kind, as this version writes it: `tests/data/saved/VERSION`, once, at its release.

    .venv/bin/pip install . && .venv/bin/python tools/save_version.py      # with the version of pyproject.toml

`tests/cli/test_saved_versions.py` reads the files of every version from then on; they are never written anew.
"""

from __future__ import annotations

import contextlib
import io
import sys
import tomllib
from pathlib import Path

from rankdrop.cli.main import run
from rankdrop.disk import replace_file
from rankdrop.version import VERSION

ROOT = Path(__file__).resolve().parents[1]
COMMANDS = {
    "analysis": "analyze planar3r --starts 100 --json",
    "analysis-within": "analyze scara --starts 100 --limits --within 5deg --json",
    "conditions": "conditions planar3r --json",
    "explanation": "explain scara --q 0.1,0,0.1,0.2 --json",
    "escape": "escape scara --q 0.1,0,0.1,0.2 --json",
    "nearest": "nearest scara --q 0.1,0.4,0.1,0.2 --json",
    "find": "find planar2r --corank 1 --starts 5 --json",
    "tolerant": "tolerant planar3r --json",
    "aspects": "aspects planar2r --json",
    "jacobian": "jacobian planar2r --json",
}
"""By the name of the file: the schema, and what is special about it."""


def main() -> int:
    """Write what is not there yet; 1 where the version has been saved already."""
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    folder = ROOT / "tests" / "data" / "saved" / version
    if version != VERSION:
        print(f"installed is {VERSION}, the source is {version}: install it first", file=sys.stderr)
        return 1
    if folder.exists():
        print(f"{folder} is there: what a version wrote does not change", file=sys.stderr)
        return 1
    folder.mkdir(parents=True)
    for name, line in COMMANDS.items():
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            run([*line.split(), "-", "--quiet"])
        replace_file(folder / f"{name}.json", said.getvalue().encode())
        print(f"{name}: {len(said.getvalue())} bytes")
    with contextlib.redirect_stdout(io.StringIO()):
        run(["cover", "planar3r", "--width", "0.4", "--out", str(folder / "cover.cover"), "--quiet"])
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
