"""Work for the tests of the engine, found by its name in every worker."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.errors import OptionError


def squares(plan: dict[str, Any], chunk: int) -> bytes:
    """A number that follows from plan and chunk, by way of BLAS; says which process made it, and sleeps if asked."""
    if plan.get("log"):
        with open(plan["log"], "a") as file:
            file.write(f"{chunk} {os.getpid()} {os.environ.get('OMP_NUM_THREADS')}\n")
    time.sleep(plan.get("sleep", 0.0))
    a = np.random.default_rng([plan["seed"], chunk]).normal(size=(60, 60))
    return f"{chunk} {float(np.linalg.qr(a @ a.T)[1].sum())!r}\n".encode()


def dies_once(plan: dict[str, Any], chunk: int) -> bytes:
    """Kills its own process the first time that it sees chunk 2."""
    mark = Path(plan["mark"])
    if chunk == 2 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return squares(plan, chunk)


def dies(plan: dict[str, Any], chunk: int) -> bytes:
    """Kills its own process whenever it sees chunk 1."""
    if chunk == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return squares(plan, chunk)


def refuses(plan: dict[str, Any], chunk: int) -> bytes:
    """An error on purpose."""
    raise OptionError("it is refused", where=f"chunk {chunk}", got=plan["seed"], allowed="nothing")


def breaks(plan: dict[str, Any], chunk: int) -> bytes:
    """An error that nobody meant."""
    raise ZeroDivisionError(f"chunk {chunk}")


def talks(plan: dict[str, Any], chunk: int) -> bytes:
    """Prints, which must not get into the answer."""
    print("hello", flush=True)
    return squares(plan, chunk)
