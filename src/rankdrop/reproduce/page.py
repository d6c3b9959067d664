"""The reproduction as one page of Markdown, docs/reproduced.md."""

from __future__ import annotations

from rankdrop.reproduce.item import Item, Verdict, count_words
from rankdrop.reproduce.run import DOCUMENTS, Reproduction

_HEAD = """# The five documents, reproduced

Every table, figure, numeric example and checkable claim of the five documents behind this package: what is printed,
what
the package computes, and a verdict that is computed from the two. The page is written by
`rankdrop reproduce all --markdown docs/reproduced.md`; a test makes it anew and compares.

- **agrees**: within half a unit of the last printed digit, or to the tolerance of the identity (1e-9 unless it says
  otherwise), or word for word.
- **rounding**: off by at most three units of the last printed digit.
- **erratum**: what is printed is not so. The reason is given, and a computation that shows it was made and holds.
- **unreproducible**: the document does not say enough to compute it, or to tell whether ours is the same thing.
- **differs**: the package and the document contradict each other without a reason. There is none of these.

"The same, within 1e-09 at random places" means that the printed formula was read as it stands, evaluated at random
configurations and compared with what the package computes there.
"""


def markdown(found: Reproduction) -> str:
    """docs/reproduced.md."""
    parts = [_HEAD, "| document | " + " | ".join(str(verdict) for verdict in Verdict) + " |"]
    parts.append("|---" * (len(Verdict) + 1) + "|")
    parts += [
        f"| [{name}](#{name.lower()}) | " + " | ".join(str(count) for _, count in found.counts(name)) + " |"
        for name in found.documents
    ]
    for name in found.documents:
        parts += ["", f"## {name}", "", f"{DOCUMENTS[name]}: {count_words(found.counts(name))}.", ""]
        parts += ["| item | what | printed | ours | verdict |", "|---|---|---|---|---|"]
        parts += [_row(item) for item in found.of(name)]
    return "\n".join(parts) + "\n"


def _row(item: Item) -> str:
    verdict = f"**{item.verdict}**" if item.verdict is not Verdict.AGREES else str(item.verdict)
    last = f"{verdict}. {item.reason}" if item.reason else verdict
    return "| " + " | ".join(_cell(text) for text in (item.item, item.about, item.printed,
        item.ours)) + f" | {_plain(last)} |"


def _cell(text: str) -> str:
    return _plain(" ".join(text.split()))


def _plain(text: str) -> str:
    """Text for a cell of a table: nothing in it is read as Markdown."""
    for letter in ("\\", "_", "$", "<", "["):
        text = text.replace(letter, "\\" + letter)
    text = text.replace("|", "\\|")
    return text if text.startswith("**") else text.replace("^", "\\^")
