"""Results of versions up to 0.2: when a family is real is read from its sentence and said again."""

from __future__ import annotations

import pytest

from rankdrop.codec import encode
from rankdrop.errors import ResultFileError
from rankdrop.exact.family import Unreal, UnrealSet
from rankdrop.results.old_files import exact_from_dict, negative_of_sentence
from rankdrop.schema.families import UNREAL

REAL = {"": (), "real if and only if a1 − a2 ≥ 0": ("a1 − a2",),
        "real if and only if a1 − a2 ≥ 0 and (d3 + d5) (d3 − d5) ≥ 0": ("a1 − a2", "(d3 + d5) (d3 − d5)")}  # fmt: skip


@pytest.mark.parametrize("sentence", REAL)
def test_when_a_family_is_real_is_read_from_its_sentence_and_said_again(sentence: str) -> None:
    exact = exact_from_dict({"conditions": ["s5 = 0"], "latex": ["s_5 = 0"], "pinned": [], "reality": sentence})
    assert exact.not_negative == REAL[sentence]
    assert exact.reality == sentence


def test_a_sentence_that_does_not_say_when_a_family_is_real_is_refused() -> None:
    with pytest.raises(ResultFileError, match="this does not say when a family is real"):
        exact_from_dict({"conditions": ["s5 = 0"], "latex": ["s_5 = 0"], "pinned": [], "reality": "real for a1 ≥ 0"})


@pytest.mark.parametrize(("negative", "words"), [("a1 − a2", "a1 − a2 ≥ 0 does not hold"),
                                                 ("", "a negative discriminant")])  # fmt: skip
def test_what_excludes_real_points_is_in_files_in_words(negative: str, words: str) -> None:
    unreal = UnrealSet("θ4 = 0", Unreal.PROVEN, negative=negative)
    assert str(unreal) == f"θ4 = 0: not real, for {words}"
    assert encode(UNREAL, unreal) == {"conditions": "θ4 = 0", "reason": "proven", "tried": 0, "proof": words}
    assert negative_of_sentence(words) == negative
