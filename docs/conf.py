"""The documentation site: `python -m sphinx -W --keep-going -n docs build/docs`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from pygments.lexers.special import TextLexer
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment

import rankdrop

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "rankdrop"
author = "the rankdrop authors"
copyright = author
version = release = rankdrop.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "docstrings", "sphinx.ext.napoleon", "mathml"]
extensions += ["gallery", "commands", "atlas"]  # pages that are made
exclude_patterns = ["_ext"]
nitpicky = True
toc_object_entries = False  # a thousand names in the sidebar's tree are copied for every page, a third of the build

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
highlight_language = "none"

autodoc_typehints = "signature"
autodoc_type_aliases = {name: name for name in ("ArrayLike", "Array", "Progress")}
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
autodoc_preserve_defaults = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88

html_theme = "furo"
html_title = f"rankdrop {release}"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#0b5c8f", "color-brand-content": "#0b5c8f"},
    "dark_css_variables": {"color-brand-primary": "#7cc4f0", "color-brand-content": "#7cc4f0"},
}


def public_name(app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.Element) -> Any:
    """A type under the name that the reader imports: rankdrop.robot.model.Robot is rankdrop.Robot.

    Types of other packages, and ours that have no entry of their own (type aliases, records of the core), stay plain
    text: their pages are elsewhere, and nothing here is fetched.
    """
    if node.get("refdomain") != "py" or node.get("reftype") not in ("class", "obj", "exc", "data"):
        return None
    name = node["reftarget"].rpartition(".")[2]
    if name in rankdrop.__all__ and node["reftarget"] != f"rankdrop.{name}":
        domain = env.domains.python_domain
        found = domain.resolve_xref(env, node["refdoc"], app.builder, "obj", f"rankdrop.{name}", node, content)
        if found is not None:
            return found
    return content


def pages_that_exist(app: Sphinx, docname: str, source: list[str]) -> None:
    """In the table of contents a line "?report" is the page report.md if there is one, and nothing else."""
    lines = source[0].split("\n") if docname == "index" else []
    if lines:
        kept = (line for line in lines if line[:1] != "?" or Path(app.srcdir, f"{line[1:]}.md").exists())
        source[0] = "\n".join(line.removeprefix("?") for line in kept)


def setup(app: Sphinx) -> None:
    """Connect what this file has of its own."""
    app.add_lexer("console", TextLexer)  # what tables print is no shell: % and numbers mean nothing there
    app.connect("source-read", pages_that_exist)
    app.connect("missing-reference", public_name)

# the decorator that takes a record or its fields has a signature that autodoc cannot print argument by argument
suppress_warnings = ["autodoc"]
