"""The gallery: a page for each numbered example, with the script and what it prints, and figures by their commands.

Scripts are not run here. `tests/docs/test_examples.py` runs them and compares what they print with `examples/output`:
the pages are true, and the site builds in seconds. The figures of docs/gallery.md are drawn by the commands that stand
under them, and kept until the version or the page changes.
"""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys
from pathlib import Path

from pages import write_pages
from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

import rankdrop

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
DRAWN = re.compile(r"!\[[^]]*\]\(gallery/(figures/[\w.-]+)\)\n\n```console\n(.*?)\n```", re.DOTALL)
"""A figure of the page and the commands under it."""


def parts(script: Path) -> tuple[str, str, str]:
    """(title, text, code) of a script: the first line of its docstring, the rest of it, and what follows.

    Raises:
        ValueError: the script has no docstring.
    """
    source = script.read_text(encoding="utf-8")
    tree = ast.parse(source)
    docstring = ast.get_docstring(tree)
    if docstring is None:
        raise ValueError(f"{script.name} has no docstring")
    title, _, text = docstring.partition("\n")
    code = "\n".join(source.splitlines()[tree.body[0].end_lineno :]).strip()
    return title.removesuffix("."), text.strip(), code


def page(script: Path) -> str:
    """The page of one script, in Markdown."""
    title, text, code = parts(script)
    printed = (EXAMPLES / "output" / f"{script.stem}.txt").read_text(encoding="utf-8").rstrip()
    return (
        f"# {title}\n\n{text}\n\n```python\n{code}\n```\n\nIt prints:\n\n```text\n{printed}\n```\n\n"
        f"The script: `examples/{script.name}`\n"
    )


def draw(text: str, folder: Path) -> None:
    """Draw the figures of the page with their own commands, in `folder`; what is drawn already stays."""
    drawn_by = folder / "figures" / "drawn-by.txt"
    made = f"{rankdrop.__version__}\n{DRAWN.findall(text)}"
    if drawn_by.exists() and drawn_by.read_text(encoding="utf-8") == made:
        return
    shutil.rmtree(folder / "figures", ignore_errors=True)
    (folder / "figures").mkdir(parents=True)
    for figure, commands in DRAWN.findall(text):
        told = re.sub(r"^rankdrop", f"'{sys.executable}' -m rankdrop", commands, flags=re.MULTILINE)
        done = subprocess.run(told, shell=True, cwd=folder, capture_output=True, text=True, check=False)  # our page
        if not (folder / figure).is_file():
            raise RuntimeError(f"{figure} of docs/gallery.md was not drawn: {done.stderr}")
    drawn_by.write_text(made, encoding="utf-8")


def write(app: Sphinx) -> None:
    """Write `gallery/*.md` into the source folder, where they have changed; docs/gallery.md lists them."""
    pages = {f"{script.stem}.md": page(script) for script in sorted(EXAMPLES.glob("[0-9]*_*.py"))}
    folder = Path(app.srcdir) / "gallery"
    write_pages(folder, pages)
    draw((Path(app.srcdir) / "gallery.md").read_text(encoding="utf-8"), folder)


def setup(app: Sphinx) -> ExtensionMetadata:
    """Write the pages before the source folder is read."""
    app.connect("builder-inited", write)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
