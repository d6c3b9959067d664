"""Save one result of every kind, as this version writes it: `tests/data/saved/VERSION`, once, at its release.

    .venv/bin/pip install . && .venv/bin/python tools/save_version.py      # with the version of pyproject.toml

`tests/cli/test_saved_versions.py` reads the files of every version from then on; they are never written anew.
"""

from __future__ import annotations

import contextlib
import io
import sys
import tempfile
import tomllib
from pathlib import Path

from rankdrop.cli import exits
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
    "through": "through planar2r --deg --q 0,180 --along 0,1 --json",
    "path": "path planar2r free.csv --certificate path.certificate --json",
    "path-rows": "path planar2r free.csv --rows rows.json --json",
    "paths": "path planar2r free.csv through.csv --json",
    "cover": "cover planar3r --width 0.4 --out cover.cover --certificate cover.certificate --json",
    "verified": "verify path.certificate --json",
    "nearest-free": "nearest planar3r --q 0.3,0.9,0.4 --certificate ball.certificate --json",
    "explanation-lost": "explain planar3r --q 0.3,0,0 --certificate existence.certificate --json",
    "sweep": "sweep sweep.toml --workers 1 --json",
    "side-by-side": "compare planar2r planar3r --starts 100 --workers 1 --json",
}
"""By the name of the file: the schema, and what is special about it."""
GIVEN = {
    "free.csv": "q1,q2\n0,1\n0.3,0.5\n",
    "through.csv": "q1,q2\n0,1\n0.3,-0.4\n",
    "sweep.toml": 'robot = "planar2r"\n[parameters]\nlength = { sets = "2.a", values = [0.5, 1.0] }\n'
                  '[families]\nstarts = 50\nexact = false\n[near]\nsamples = 200\n',
}  # fmt: skip
"""Files that commands read."""
FILES = {"cover.certificate": "certificate-cover.json", "path.certificate": "certificate-path.json",
         "ball.certificate": "certificate.json", "existence.certificate": "certificate-existence.json",
         "rows.json": "path-rows.json"}  # fmt: skip
"""What commands write beside what they print, and under which name it is kept."""


def said_by(line: str) -> str:
    """What a command prints; it ends with an error where it is refused."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        code = run([*line.split(), "-", "--quiet"])
    if code not in (exits.FINE, exits.UNEXPLAINED, exits.SINGULAR):
        raise SystemExit(f"rankdrop {line}: exit code {code}")
    return said.getvalue()


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
    with tempfile.TemporaryDirectory() as made, contextlib.chdir(made):  # names of files in results are without a place
        for name, text in GIVEN.items():
            replace_file(name, text.encode())
        for name, line in COMMANDS.items():
            replace_file(f"{name}.json", said_by(line).encode())
        for name, kept in FILES.items():
            Path(name).replace(kept)
        folder.mkdir(parents=True)
        for file in sorted(Path().iterdir()):
            if file.name not in GIVEN:
                replace_file(folder / file.name, file.read_bytes())
                print(f"{file.name}: {file.stat().st_size} bytes")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
