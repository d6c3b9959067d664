"""A derivation in files: why it is none, in words; what contradicts it, as facts and in sentences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_type_hints

from rankdrop.codec import Record, restore
from rankdrop.families.contradiction import Contradiction
from rankdrop.families.derivation import Derivation
from rankdrop.families.not_derived import NotDerived
from rankdrop.results.names import name_from_dict

_KINDS: dict[str, Any] = {name: kind for name, kind in get_type_hints(Contradiction).items() if name != "called"}
"""Entry that is a field of a contradiction as it stands -> its type."""
_WORDED = ("reason", "disagreements")
"""Entries of a derivation that are words."""
_ENTRIES: dict[str, Any] = {name: kind for name, kind in get_type_hints(Derivation).items() if name not in _WORDED}
"""Entry that is a field of a derivation as it stands -> its type."""


def derivation_from_dict(record: Record) -> Derivation:
    """The derivation of an analysis of a file.

    Raises:
        ValueError: an entry is missing, or is something else.
    """
    return Derivation(
        **_fields(_ENTRIES, record),
        reason=_reason(restore(str, record.get("reason", ""))),
        disagreements=_contradictions(record),
    )


def _reason(sentence: str) -> NotDerived | None:
    """Why nothing was derived; None for "", where the families were derived."""
    if not sentence:
        return None
    from rankdrop.results.old_sentences import reason_of_sentence  # with all exact algebra

    return reason_of_sentence(sentence)


def _fields(kinds: Mapping[str, Any], record: Record) -> dict[str, Any]:
    return {name: restore(kind, record[name]) for name, kind in kinds.items() if name in record}


def _contradictions(record: Record) -> tuple[Contradiction, ...]:
    """What contradicts a derivation; in files up to version 0.2, of its sentences."""
    facts = record.get("contradictions")
    if facts is not None:
        return tuple(map(_contradiction, facts))
    sentences = record.get("disagreements", ())
    if not sentences:
        return ()
    from rankdrop.results.old_sentences import contradictions_of_sentences  # with all exact algebra

    return contradictions_of_sentences(sentences)


def _contradiction(record: Record) -> Contradiction:
    fields = _fields(_KINDS, record)
    called = record.get("called")
    if called is not None:
        fields["called"] = name_from_dict(called)
    return Contradiction(**fields)
