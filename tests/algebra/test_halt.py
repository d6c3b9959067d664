"""Why work ended early is a fact that has words."""

from __future__ import annotations

import pytest

from rankdrop.algebra.halt import Halt, HaltKind
from rankdrop.algebra.work import Work, halt_of
from rankdrop.text.unfinished import halt_words


def test_a_limit_is_a_fact() -> None:
    work = Work(-1.0)
    with pytest.raises(Exception, match="limit on work") as met:
        work.check()
    assert halt_of(met.value) == Halt(HaltKind.WORK)
    assert halt_words(halt_of(ValueError("no"))) == "ValueError: no"
