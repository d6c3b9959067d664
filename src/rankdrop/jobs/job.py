"""What a long job is: a plan in plain data, so many chunks, and a function that makes one of them.

The bytes of a chunk follow from the plan and its number alone: not from the worker, the machine's load, nor from what
other chunks were made before it. Then one process, many, a cluster and a run that was killed and resumed end with the
same bytes.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from hashlib import sha256
from importlib import import_module
from typing import Any

from rankdrop.errors import RankdropError
from rankdrop.version import VERSION

Plan = dict[str, Any]
Work = Callable[[Plan, int], bytes]


@dataclass(frozen=True)
class Job:
    """A job to do.

    Attributes:
        kind: in a word: "sweep".
        work: "module:function"; the function takes (plan, number of the chunk) and returns the chunk's bytes. It is
            named, not handed over, so that any worker of any machine can find it.
        plan: all that decides the result, as plain data of JSON.
        chunks: how many there are.
        items: how many things (variants, starts, paths) there are in all chunks; for progress.
        ending: of the files in which chunks are kept.
    """

    kind: str
    work: str
    plan: Plan
    chunks: int
    items: int
    ending: str = ".json"

    @property
    def line(self) -> str:
        """What tells the job from another one: its kind, plan and chunks, and the version of rankdrop."""
        told = {"kind": self.kind, "work": self.work, "plan": self.plan, "chunks": self.chunks, "version": VERSION}
        return json.dumps(told, sort_keys=True, ensure_ascii=False, allow_nan=False)

    @property
    def sha256(self) -> str:
        """Of its line."""
        return sha256(self.line.encode()).hexdigest()


def perform(work: str, plan: Plan, chunk: int) -> bytes:
    """One chunk, made here and now: what every worker runs.

    Raises:
        RankdropError: as the function of the job raises it.
    """
    module, _, name = work.partition(":")
    made: bytes = getattr(import_module(module), name)(plan, chunk)
    return made


def error_to_dict(error: RankdropError) -> dict[str, Any]:
    """An error as plain data, for the way from a worker."""
    parts = {name: getattr(error, name) for name in ("what", "where", "got", "allowed", "mend", "typed")}
    return {name: None if value is None else str(value) for name, value in parts.items()}


def error_from_dict(record: dict[str, Any]) -> RankdropError:
    """The error of a record made by `error_to_dict`."""
    return RankdropError(**record)
