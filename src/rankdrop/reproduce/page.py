"""The reproduction as sections for the terminal, and as one page of Markdown."""

from __future__ import annotations

from rankdrop.reproduce.item import Item, Verdict, count_words
from rankdrop.reproduce.run import DOCUMENTS, Reproduction
from rankdrop.sections import Section

_LONGEST = 110  # characters of a cell on the terminal; the JSON and the page have all of it
_HEAD = """# The five documents, reproduced

Every table, figure, numeric example and checkable claim of the five documents behind this package: what is printed, what
the package computes, and a verdict that is computed from the two. The page is written by
`rankdrop reproduce all --markdown docs/reproduced.md`; a test makes it anew and compares.

- **agrees**: within half a unit of the last printed digit, or to the tolerance of the identity (1e-9 unless it says
  otherwise), or word for word.
- **rounding**: off by at most three units of the last printed digit.
- **erratum**: what is printed is not so. The reason is given, and a computation that shows it was made and holds.
- **unreproducible**: the document does not say enough to compute it.
- **differs**: the package and the document contradict each other without a reason. There is none of these.

"The same, within 1e-09 at random places" means that the printed formula was read as it stands, evaluated at random
configurations and compared with what the package computes there.
"""


def sections(found: Reproduction, *, full: bool = False) -> tuple[Section, ...]:
    """Per document one table and the reasons under it.

    Args:
        found: what was reproduced.
        full: whole cells, and the reasons of items that agree as well.
    """
    made = [_section(found, name, full) for name in found.documents]
    if len(made) > 1:
        made.append(Section("All", summary=count_words(found.counts())))
    return tuple(made)


def _section(found: Reproduction, name: str, full: bool) -> Section:
    items = found.of(name)
    rows = tuple(
        (item.item, _cut(item.about, full), _cut(item.printed, full), _cut(item.ours, full), str(item.verdict))
        for item in items
    )
    reasons = [item for item in items if item.reason and (full or item.verdict is not Verdict.AGREES)]
    return Section(
        f"{name}  {DOCUMENTS[name]}",
        summary=count_words(found.counts(name)),
        columns=("item", "what", "printed", "ours", "verdict"),
        rows=rows,
        texts=(0, 1, 2, 3, 4),
        after=tuple(f"{item.verdict}: {item.item}, {item.about}: {item.reason}" for item in reasons),
    )


def _cut(text: str, full: bool) -> str:
    flat = " ".join(text.split())
    return flat if full or len(flat) <= _LONGEST else f"{flat[: _LONGEST - 1]}…"


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
    return "| " + " | ".join(_cell(text) for text in (item.item, item.about, item.printed, item.ours)) + f" | {_plain(last)} |"


def _cell(text: str) -> str:
    return _plain(" ".join(text.split()))


def _plain(text: str) -> str:
    """Text for a cell of a table: nothing in it is read as Markdown."""
    for letter in ("\\", "_", "$", "<", "["):
        text = text.replace(letter, "\\" + letter)
    text = text.replace("|", "\\|")
    return text if text.startswith("**") else text.replace("^", "\\^")
