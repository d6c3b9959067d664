"""Documents reproduced: every item of each, in order, the record that goes to a file, and docs/reproduced.md."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from importlib import import_module
from string import ascii_lowercase

from papers.item import Item, Sheet, Verdict
from rankdrop.errors import OptionError
from rankdrop.results import Record
from rankdrop.units import heading
from rankdrop.version import VERSION

SCHEMA = "rankdrop/reproduced/1"
DOCUMENTS = {
    "AM": "Almarkhi and Maciejewski, Singularity Analysis for Redundant Manipulators of Arbitrary Kinematic Structure",
    "ML": "Memon, Kinematic Singularities (lecture)",
    "GR": "Gallardo-Alvarado and Rico-Martínez, An Application of the Lie Product to the Higher Singular "
    "Configurations Problem of Serial Manipulators",
    "KG": "A dependent-screw suppression approach to the singularity analysis of 7-DOF redundant manipulators, "
    "Canadarm2",
    "JL": "Jin, Lecture 13: Singularity and Redundancy",
}
"""Short name -> what it is."""
ALL = "all"
Progress = Callable[[str, int, int], None]
"""progress(label, parts done, parts in all)"""


@dataclass(frozen=True, slots=True)
class Reproduction:
    """What was reproduced.

    Attributes:
        documents: short names, in the order asked for.
        items: of all of them, document by document.
        complete: False where Ctrl-C ended it early.
    """

    documents: tuple[str, ...]
    items: tuple[Item, ...]
    complete: bool = True

    @property
    def differs(self) -> tuple[Item, ...]:
        """Items that neither agree nor are explained."""
        return tuple(item for item in self.items if item.verdict is Verdict.DIFFERS)

    def of(self, document: str) -> tuple[Item, ...]:
        """The items of one document."""
        return tuple(item for item in self.items if item.document == document)

    def count(self, verdict: str, document: str | None = None) -> int:
        """How many items have a verdict, of one document or of all."""
        return sum(item.verdict == verdict and document in (None, item.document) for item in self.items)

    def counts(self, document: str | None = None) -> tuple[tuple[str, int], ...]:
        """(verdict, how many) in the order of `Verdict`."""
        return tuple((str(verdict), self.count(verdict, document)) for verdict in Verdict)

    def to_dict(self) -> Record:
        """Plain data, as `--json` writes it."""
        return {
            **heading(SCHEMA),
            "version": VERSION,
            "complete": self.complete,
            "documents": [
                {"name": name, "title": DOCUMENTS[name], "counts": dict(self.counts(name))} for name in self.documents
            ],
            "items": [asdict(item) for item in self.items],
        }


def names(document: str) -> tuple[str, ...]:
    """The documents that a word asks for; "all" is all five.

    Raises:
        OptionError: there is no such document.
    """
    wanted = document.strip().upper()
    if wanted == ALL.upper():
        return tuple(DOCUMENTS)
    if wanted not in DOCUMENTS:
        raise OptionError("there is no such document", got=repr(document), allowed=", ".join((*DOCUMENTS, ALL)))
    return (wanted,)


def reproduce(document: str = ALL, *, progress: Progress | None = None) -> Reproduction:
    """Compute every printed table row, figure, equation, example and claim of a document, and compare.

    Every random choice has a fixed seed.

    Args:
        document: "AM", "ML", "GR", "KG", "JL" or "all".
        progress: called before each part and at the end.

    Returns:
        A `Reproduction`. On Ctrl-C the parts already done are kept.

    Raises:
        OptionError: there is no such document.
        MissingExtraError: python-flint is not installed (all but GR need exact conditions).
    """
    wanted = names(document)
    parts = [(name, part) for name in wanted for _, part in _sections(name)]
    items: list[Item] = []
    for done, (name, part) in enumerate(parts):
        sheet = Sheet(name, [])
        try:
            if progress is not None:
                progress("reproduce", done, len(parts))
            part(sheet)
        except KeyboardInterrupt:
            return Reproduction(wanted, tuple(items), complete=False)
        items += sheet.items
    if progress is not None:
        progress("reproduce", len(parts), len(parts))
    return Reproduction(wanted, tuple(items))


def _sections(name: str) -> Iterable[tuple[str, Callable[[Sheet], None]]]:
    sections: Iterable[tuple[str, Callable[[Sheet], None]]] = import_module(
        f"papers.{name.lower()}"
    ).SECTIONS
    return sections


_HEAD = """# The five documents, reproduced

Every table, figure, numeric example and checkable claim of the five documents behind this package: what is printed,
what the package computes, and a verdict that is computed from the two. The page is written by
`python -m papers all --markdown docs/reproduced.md`; a test makes it anew and compares.

- **agrees**: within half a unit of the last printed digit, or to the tolerance of the identity, or word for word.
- **rounding**: off by at most three units of the last printed digit.
- **erratum**: what is printed is not so. The reason is given, and a computation that shows it was made and holds.
- **unreproducible**: the document does not say enough to compute it, or to tell whether ours is the same thing.
- **differs**: the package and the document contradict each other without a reason. There is none of these.

What agrees is listed as place, quantity: printed value → our value. Without an arrow ours is the printed one; without
a place, the place is that of the line above. A printed formula was read as it stands and evaluated at random
configurations: it agrees with what the package computes there to 1e-9, or as is stated. Letters in brackets are the
notes above a list.
"""
_OFTEN = 3
"""Sentences that a document's items repeat so often become notes."""


def markdown(reproduction: Reproduction) -> str:
    """docs/reproduced.md."""
    parts = [_HEAD, "| document | " + " | ".join(str(verdict) for verdict in Verdict) + " |"]
    parts.append("|---" * (len(Verdict) + 1) + "|")
    parts += [
        f"| [{name}](#{name.lower()}) | " + " | ".join(str(count) for _, count in reproduction.counts(name)) + " |"
        for name in reproduction.documents
    ]
    for name in reproduction.documents:
        items = reproduction.of(name)
        notes = _notes(items)
        parts += ["", f"## {name}", "", f"{DOCUMENTS[name]}.", ""]
        parts += [f"- ({letter}) {_plain(sentence)}" for sentence, letter in notes.items()]
        others = [item for item in items if item.verdict is not Verdict.AGREES]
        if others:
            parts += [*([""] if notes else []), "| item | what | printed | verdict, ours |", "|---|---|---|---|"]
            parts += [_row(item, notes) for item in others]
        agreeing = [item for item in items if item.verdict is Verdict.AGREES]
        places = ["", *(item.item for item in agreeing)]
        parts += ["", "Agrees:", ""]
        parts += [_line(item, place, notes) for item, place in zip(agreeing, places, strict=False)]
    return "\n".join(parts) + "\n"


def _notes(items: Iterable[Item]) -> dict[str, str]:
    """Sentence that several reasons contain -> its letter."""
    counts = Counter(sentence for item in items for sentence in _sentences(item.reason))
    often = [sentence for sentence, count in counts.items() if count >= _OFTEN]
    return dict(zip(often, ascii_lowercase, strict=False))


def _sentences(text: str) -> list[str]:
    return re.split(r"(?<=\.) (?=[A-Z])", text) if text else []


def _row(item: Item, notes: Mapping[str, str]) -> str:
    """The line of a table: an item that does not agree."""
    marks, rest = _marked(item, notes)
    said = f"**{item.verdict}**{marks}: {item.ours}{rest}"
    return "| " + " | ".join(_cell(text) for text in (item.item, item.about, item.printed, said)) + " |"


def _line(item: Item, before: str, notes: Mapping[str, str]) -> str:
    """The line of a list: an item that agrees, with its place where that is not the place of the line before."""
    marks, rest = _marked(item, notes)
    place = "" if item.item == before else f"{item.item}, "
    ours = item.ours.removeprefix("the same, ").removesuffix(" at random places")
    arrow = "" if ours in (" ".join(item.printed.split()), "within 1e-09") else f" → {ours}"
    return "- " + _cell(f"{place}{item.about}: {item.printed}{arrow}{marks}{rest}")


def _marked(item: Item, notes: Mapping[str, str]) -> tuple[str, str]:
    """The letters of its notes, and what else its reason has."""
    sentences = _sentences(item.reason)
    letters = ", ".join(notes[sentence] for sentence in sentences if sentence in notes)
    rest = " ".join(sentence for sentence in sentences if sentence not in notes)
    return f" ({letters})" if letters else "", f". {rest}" if rest else ""


def _cell(text: str) -> str:
    """Text in one line; columns of a row are separated by commas, or by semicolons where it has commas."""
    flat = " ".join(text.split())
    return _plain(flat.replace(" | ", "; " if ", " in flat else ", "))


def _plain(text: str) -> str:
    """Text for a cell of a table: nothing in it is read as Markdown."""
    for letter in ("\\", "_", "$", "<", "["):
        text = text.replace(letter, "\\" + letter)
    text = text.replace("|", "\\|")
    return text if text.startswith("**") else text.replace("^", "\\^")
