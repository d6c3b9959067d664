"""How far a long job is."""

from __future__ import annotations

from rankdrop.jobs.running import Progress


def progress_words(progress: Progress) -> str:
    """How far the job of a folder is.

    Example:
        >>> progress_words(Progress("sweep", done=3, chunks=8, items=40, seconds=6.0, quiet=2.0, left=10.0))
        '3 of 8 chunks of the sweep (40 items in all); last one 2 s ago; about 10 s left at the pace so far'
    """
    share = f"{progress.done} of {progress.chunks} chunks of the {progress.kind} ({progress.items} items in all)"
    if progress.done == progress.chunks:
        return f"finished: {share}"
    quiet = f"{share}; last one {progress.quiet:.0f} s ago"
    if progress.left is None:
        return quiet
    return f"{quiet}; about {progress.left:.0f} s left at the pace so far"
