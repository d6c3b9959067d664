"""Run a foreign parser in a child process with limits on memory, processor time and files.

MuJoCo's compiler, xacro, meshes and ROS bags unpack what a file asks for: 200 bytes may ask for gigabytes.
The child reads the file and returns plain data. A child that meets a limit, or crashes, is one line of error.

Limits hold where the system has them: memory on Linux, processor time and written files on Linux and macOS, waiting
time everywhere. On Linux the child has no network where a network namespace may be made.
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rankdrop.errors import RankdropError, RobotError
from rankdrop.jobs.running import error_to_dict

MEMORY = 2**30
"""Bytes of data that a child may hold."""
CPU = 30
"""Processor time of a child [s]."""
PATIENCE = 20 * CPU
"""Time by the clock that a child may take [s]: waiting for a pipe costs no processor time."""
_NEW_USER, _NEW_NETWORK = 0x10000000, 0x40000000  # CLONE_NEWUSER, CLONE_NEWNET
_OUT_OF_MEMORY = 3  # exit code of a child
_TEMPORARY = ("TMPDIR", "TEMP", "TMP")  # where Python looks for a folder of temporary files
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")  # each takes memory


def run_limited(
    function: Callable[..., Any], *arguments: Any, file: str | Path, parser: str,
    memory: int | None = None, cpu: int | None = None, scratch: int = 0, error: type[RankdropError] = RobotError,
) -> Any:
    """The result of a function that is called in a child process with limits.

    Args:
        function: of a module, by its own name; it returns bytes, or plain data as JSON holds it.
        arguments: plain data.
        file: that is read, for errors.
        parser: whose code reads it, for errors ("MuJoCo").
        memory: data that the child may hold [bytes]; None for `MEMORY`.
        cpu: processor time of the child [s]; None for `CPU`.
        scratch: bytes that a file may have which the child writes; it has a temporary folder of its own then, which is
            removed afterwards, however the child ends. 0: the child writes nothing.
        error: type of all errors.

    Raises:
        RankdropError: of the given type: what the function raises as one; the child meets a limit or crashes.
    """
    memory, cpu = memory or MEMORY, cpu or CPU
    paths = [str(Path(__file__).resolve().parents[2]), *(path for path in sys.path if path)]
    request = {"function": [function.__module__, function.__name__], "arguments": arguments,
               "limits": [memory, cpu, scratch]}  # fmt: skip
    environment = {**os.environ, **_ONE_THREAD, "PYTHONPATH": os.pathsep.join(paths)}
    with tempfile.TemporaryDirectory(prefix="rankdrop-") if scratch else contextlib.nullcontext() as folder:
        if folder is not None:
            environment |= dict.fromkeys(_TEMPORARY, folder)
        try:
            child = subprocess.run(
                # -B: under the limit on files a compiled module would be cut off, and read so by the next one
                [sys.executable, "-P", "-B", "-m", "rankdrop.jobs.limited"], input=json.dumps(request).encode(),
                timeout=PATIENCE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            raise error(f"{parser} does not finish reading the file", where=str(file),
                        allowed=f"{PATIENCE} s") from None  # fmt: skip
    kind, _, content = child.stdout.partition(b"\n")
    if child.returncode != 0 or kind not in (b"bytes", b"json", b"error"):
        raise error(f"{parser} {_end_of(child.returncode, memory, cpu)}", where=str(file),
                    mend="read only files that you trust, and simplify this one")  # fmt: skip
    if kind == b"error":
        raise error(**json.loads(content))
    if kind == b"bytes":
        return content
    return json.loads(content)


def _end_of(code: int, memory: int, cpu: int) -> str:
    if code == _OUT_OF_MEMORY:
        return f"needs more than {memory / 2**30:g} GB of memory for the file"
    if code < 0 and signal.Signals(-code).name in ("SIGXCPU", "SIGKILL"):
        return f"needs more than {cpu} s of processor time for the file"
    return f"crashes on the file (exit code {code})"


def _serve() -> None:
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what the parser prints goes nowhere
    request = json.loads(sys.stdin.buffer.read())
    module, name = request["function"]
    _limit(*request["limits"])
    try:
        result = getattr(importlib.import_module(module), name)(*request["arguments"])
        if isinstance(result, bytes):
            kind, content = ("bytes", result)
        else:
            kind, content = ("json", json.dumps(result).encode())
    except RankdropError as error:
        kind, content = "error", json.dumps(error_to_dict(error)).encode()
    except MemoryError:
        os._exit(_OUT_OF_MEMORY)
    except Exception as error:  # a foreign parser raises whatever it likes
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        kind, content = "error", json.dumps({"what": f"the file cannot be read: {reason}"}).encode()
    answers.write(kind.encode() + b"\n" + content)
    answers.flush()
    os._exit(0)  # libraries may crash as they end


def _limit(memory: int, cpu: int, scratch: int) -> None:
    """Set the limits of this process, and cut it off from the network, as far as the system can."""
    try:
        import resource
    except ImportError:  # Windows
        return
    for limit, most in ((resource.RLIMIT_DATA, memory), (resource.RLIMIT_CPU, cpu), (resource.RLIMIT_FSIZE, scratch),
                        (resource.RLIMIT_CORE, 0)):  # fmt: skip
        with contextlib.suppress(OSError, ValueError):  # a lower one is set already
            resource.setrlimit(limit, (most, most))
    if sys.platform == "linux":
        unshare = getattr(ctypes.CDLL(None), "unshare", None)  # os.unshare comes with Python 3.12
        if unshare is not None and unshare(_NEW_NETWORK) != 0 and os.getuid() != 0:
            unshare(_NEW_USER | _NEW_NETWORK)  # a user without rights may make one inside a user namespace


if __name__ == "__main__":
    _serve()
