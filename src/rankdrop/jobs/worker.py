"""A worker: a process of its own that makes chunks, told over its standard input, and answers over its output.

Of its own, so that BLAS has one thread from the beginning, a crash or a kill costs one chunk, and a caller's script is
never imported by it. In: one line of JSON with work and plan, then a line with a number for each chunk. Out, for each:
a line "ok LENGTH", "error LENGTH" or "broken LENGTH", then so many bytes: the chunk, an error as JSON, or a traceback.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import traceback

from rankdrop.errors import RankdropError
from rankdrop.jobs.folder import error_to_dict, perform


def main() -> None:
    """Answer until the input ends. What the work prints goes to standard error."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which then closes the input
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    job = json.loads(sys.stdin.buffer.readline())
    for line in sys.stdin.buffer:
        kind, content = _answer(job, int(line))
        try:
            answers.write(f"{kind} {len(content)}\n".encode() + content)
            answers.flush()
        except BrokenPipeError:  # nobody is there any more: the parent was killed
            os._exit(0)


def _answer(job: dict[str, object], chunk: int) -> tuple[str, bytes]:
    try:
        return "ok", perform(str(job["work"]), job["plan"], chunk)  # type: ignore[arg-type]  # plain data of a Job
    except RankdropError as error:
        return "error", json.dumps(error_to_dict(error)).encode()
    except Exception:  # whatever it is goes to the parent, which raises it with the traceback
        return "broken", traceback.format_exc().encode()


if __name__ == "__main__":
    main()
