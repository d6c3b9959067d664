"""The gallery: a page for each numbered example, with the script and what it prints.

Scripts are not run here. `tests/docs/test_examples.py` runs them and compares what they print with `examples/output`:
the pages are true, and the site builds in seconds.
"""

from __future__ import annotations

import ast
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"

OPENING = """# Gallery

Each page is a script of the folder `examples`, with what it prints. All of them are run by the tests, and what they \
print is compared with what is shown here. From a copy of the project: `python examples/{first}`.

"""


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


def write_pages(app: Sphinx) -> None:
    """Write `gallery/*.md` and their index into the source folder, where they have changed."""
    folder = Path(app.srcdir) / "gallery"
    folder.mkdir(exist_ok=True)
    scripts = sorted(EXAMPLES.glob("[0-9]*_*.py"))
    pages = {f"{script.stem}.md": page(script) for script in scripts}
    lines = [f"- [{parts(script)[0]}]({script.stem}.md)" for script in scripts]
    tree = "\n".join(script.stem for script in scripts)
    index = OPENING.format(first=scripts[0].name) + "\n".join(lines)
    pages["index.md"] = f"{index}\n\n```{{toctree}}\n:hidden:\n\n{tree}\n```\n"
    for old in folder.glob("*.md"):
        if old.name not in pages:
            old.unlink()
    for name, text in pages.items():
        target = folder / name
        if not target.exists() or target.read_text(encoding="utf-8") != text:
            target.write_text(text, encoding="utf-8")


def setup(app: Sphinx) -> ExtensionMetadata:
    """Write the pages before the source folder is read."""
    app.connect("builder-inited", write_pages)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
