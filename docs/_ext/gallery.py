"""The gallery: a page for each numbered example, with the script and what it prints.

Scripts are not run here. `tests/docs/test_examples.py` runs them and compares what they print with `examples/output`:
the pages are true, and the site builds in seconds.
"""

from __future__ import annotations

import ast
from pathlib import Path

from pages import write_pages
from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"


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


def write(app: Sphinx) -> None:
    """Write `gallery/*.md` into the source folder, where they have changed; docs/gallery.md lists them."""
    pages = {f"{script.stem}.md": page(script) for script in sorted(EXAMPLES.glob("[0-9]*_*.py"))}
    write_pages(Path(app.srcdir) / "gallery", pages)


def setup(app: Sphinx) -> ExtensionMetadata:
    """Write the pages before the source folder is read."""
    app.connect("builder-inited", write)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
