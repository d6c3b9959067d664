"""Relations of joint axes."""

from __future__ import annotations

from rankdrop.local.relations import Relation


def relation_words(found: tuple[Relation, ...]) -> list[tuple[bool, str]]:
    return [(relation.structural, relation.words) for relation in found]
