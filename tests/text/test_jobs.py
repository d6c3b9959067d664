"""How far a long job is, in words."""

from __future__ import annotations

from dataclasses import replace

from rankdrop.jobs.running import Progress
from rankdrop.text.jobs import progress_words

HALF = Progress("sweep", done=3, chunks=8, items=40, seconds=6.0, quiet=2.4, left=10.6)


def test_a_job_says_its_share_its_last_chunk_and_what_is_left() -> None:
    assert progress_words(HALF) == (
        "3 of 8 chunks of the sweep (40 items in all); last one 2 s ago; about 11 s left at the pace so far"
    )


def test_without_a_pace_nothing_is_said_of_what_is_left() -> None:
    assert progress_words(replace(HALF, left=None)).endswith("; last one 2 s ago")


def test_a_finished_job_has_nothing_left() -> None:
    assert progress_words(replace(HALF, done=8)) == "finished: 8 of 8 chunks of the sweep (40 items in all)"
