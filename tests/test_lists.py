"""Parts of all items, items left out by identity, and sets that contain none of the others."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rankdrop.lists import flat_map, leave_out, smallest_sets

SETS = st.lists(st.frozensets(st.integers(0, 5), max_size=4), max_size=8)


@given(st.lists(st.lists(st.integers())))
def test_all_parts_are_there_in_their_order(items: list[list[int]]) -> None:
    assert flat_map(reversed, items) == [part for item in items for part in item[::-1]]


def test_an_equal_item_that_is_another_object_stays() -> None:
    first, second = [1], [1]
    (kept,) = leave_out([first, second], [second])
    assert kept is first


@given(SETS)
def test_every_set_contains_one_that_is_kept_and_none_that_is_kept_contains_another(sets: list[frozenset[int]]) -> None:
    kept = smallest_sets(sets)
    assert all(any(least <= members for least in kept) for members in sets)
    assert not any(one < other for one in kept for other in kept)
    assert all(members in sets for members in kept)
