"""Hostile files for every reader: whatever the bytes are, a reader gives what it is to give, or says what is wrong.

    .venv/bin/python tools/fuzz_readers.py robot --cases 100000      # one reader; needs the package atheris
    .venv/bin/python tools/fuzz_readers.py csv --blind               # without coverage: Python alone
    .ci/fuzz 20000                                                   # every reader, so many cases each

Guided by coverage of the package (atheris, a libFuzzer for Python); what reached something new is kept in --corpus, and
what failed in --found. Blind, the cases run in a process of their own: one that takes more than 30 s of the processor,
1 GB of memory, or the process with it, fails; a case in forty is blown up to as much as 1 MB. `tests/data/fuzz` holds a
small corpus of each reader, which `tests/robot/test_fuzz.py` reads again in every run. Exit code 1 where a case fails.
"""

from __future__ import annotations

import argparse
import contextlib
import copy
import hashlib
import io
import json
import queue
import random
import re
import resource
import subprocess
import sys
import tempfile
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

SEEDS = Path(__file__).resolve().parents[1] / "tests" / "data" / "fuzz"
LONGEST = 4096  # bytes of most cases
GROWN = 1 << 20  # bytes that a case may be blown up to
ONE_IN = 40  # cases that are blown up
SECONDS, MEMORY = 30.0, 1 << 30
"""Processor time and memory of a case beyond which it has failed."""
PATIENCE = 1800.0  # s of wall time: a case that waits for something has failed as well, a busy machine has not
EXTREME = (b"1e308", b"-1", b"nan", b"inf", b"1e-320", b"9" * 40, b"\x00", b"\x1b[2J", b"[" * 99)
NAMES = ("robot", "quantity", "configuration", "tolerance", "csv", "message", "yaml", "npy", "poses", "poses-json",
         "poses-yaml", "analysis", "cover", "certificate", "spec", "mjcf", "npz", "bag", "mcap", "mesh", "xacro", "job",
         "arguments")  # fmt: skip


def readers(folder: Path) -> dict[str, Callable[[bytes], object]]:
    """Each reader by name: it takes the bytes of a file, written into `folder`, and may raise RankdropError."""
    from rankdrop.cli import exits
    from rankdrop.cli.main import run
    from rankdrop.cli.values import parse_configuration
    from rankdrop.cover import verify
    from rankdrop.cover.covering import load_covering
    from rankdrop.designs.spec import read_spec
    from rankdrop.jobs.running import JOB, JOURNAL, progress_of
    from rankdrop.kinematics import jacobian, pose
    from rankdrop.path.read.files import read_trajectory
    from rankdrop.path.read.poses import holds_poses, read_poses
    from rankdrop.proof.record import with_hash
    from rankdrop.results.analysis import Analysis
    from rankdrop.robot.ideal import read_tolerance
    from rankdrop.robot.mesh_file import read_meshes
    from rankdrop.robot.open import open_robot
    from rankdrop.robot.quantities import quantity

    arm = open_robot("scara")

    def written(data: bytes, ending: str) -> Path:
        path = folder / f"case{ending}"
        path.write_bytes(data)
        return path

    def robot(ending: str) -> Callable[[bytes], object]:
        def read(data: bytes) -> object:
            with contextlib.chdir(folder):  # MuJoCo writes its warnings into the working folder, MUJOCO_LOG.TXT
                found = open_robot(written(data, ending))
            zero = np.zeros(found.n)
            assert np.isfinite(pose(found, zero)).all()
            assert np.isfinite(jacobian(found, zero)).all()
            return found

        return read

    def trajectory(ending: str) -> Callable[[bytes], object]:
        def read(data: bytes) -> object:
            found = read_trajectory(written(data, ending), arm)
            assert np.isfinite(found.q).all()
            assert found.q.shape[1] == arm.n
            return found

        return read

    def poses(ending: str) -> Callable[[bytes], object]:
        def read(data: bytes) -> object:
            path = written(data, ending)
            holds_poses(path, arm)
            found = read_poses(path)
            assert np.isfinite(found.matrices).all()
            return found

        return read

    def certificate(data: bytes) -> object:
        """Sealed again: what is behind the hash is read, and checked for some work."""
        with contextlib.suppress(ValueError, RecursionError):
            record = json.loads(data)
            data = json.dumps(with_hash(record) if isinstance(record, dict) else record).encode()
        return verify(written(data, ".json"), enclosures=200)

    def number(data: bytes) -> object:
        text = data.decode("utf-8", "replace")
        value = quantity(text, "angle" if len(data) % 2 else "length", where="case")
        assert np.isfinite(value)
        return value

    def configuration(data: bytes) -> object:
        values = parse_configuration(data.decode("utf-8", "replace"), arm, deg=bool(len(data) % 2))
        assert np.isfinite(values).all()
        return values

    def mesh(data: bytes) -> object:
        path = written(data, _ending_of_mesh(data))
        (found,) = read_meshes([path]).values()
        if isinstance(found, Exception):
            raise found
        assert all(np.isfinite(part.vertices).all() for part in found)
        return found

    def job(data: bytes) -> object:
        """The two files of a job's folder, parted by a null byte."""
        note, _, journal = data.partition(b"\0")
        place = folder / "job"
        place.mkdir(exist_ok=True)
        (place / JOB).write_bytes(note)
        (place / JOURNAL).write_bytes(journal)
        return progress_of(place).sentence

    def arguments(data: bytes) -> object:
        """A command, one argument a line; whatever the arguments are, nothing ends by an internal error."""
        given = data.decode("utf-8", "surrogateescape").split("\n")
        said, wrong = io.StringIO(), io.StringIO()
        with contextlib.chdir(folder), contextlib.redirect_stdout(said), contextlib.redirect_stderr(wrong):
            code = run(given)
        assert code != exits.INTERNAL, wrong.getvalue()[-2000:]
        assert code in exits.MEANING, f"exit code {code}"
        return code

    found = (robot(".txt"), number, configuration, lambda data: read_tolerance(data.decode("utf-8", "replace")),
             trajectory(".csv"), trajectory(".json"), trajectory(".yaml"), trajectory(".npy"),
             poses(".csv"), poses(".json"), poses(".yaml"), lambda data: Analysis.load(written(data, ".json")),
             lambda data: load_covering(written(data, ".cover")), certificate,
             lambda data: read_spec(written(data, ".toml")), robot(".xml"), trajectory(".npz"), trajectory(".bag"),
             trajectory(".mcap"), mesh, robot(".xacro"), job, arguments)  # fmt: skip
    return dict(zip(NAMES, found, strict=True))


def _ending_of_mesh(data: bytes) -> str:
    """The ending of a mesh file with these bytes: a reader is chosen by it."""
    if data.startswith(b"ply"):
        return ".ply"
    if data.lstrip().startswith(b"<"):
        return ".dae"
    if data.startswith((b"v ", b"#", b"o ")):
        return ".obj"
    return ".stl"


def judged(read: Callable[[bytes], object], data: bytes) -> bool:
    """Whether the reader takes the bytes; False where it says what is wrong with them.

    Raises:
        Exception: whatever else comes out, a warning of NumPy included, and sentences that cannot be printed.
    """
    from rankdrop.errors import HIDDEN, RankdropError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            read(data)
    except RankdropError as error:
        text = str(error)
        assert text, "an error without a word"
        assert text.translate(HIDDEN) == text, f"control characters in {text!r}"
        return False
    return True


def seeds(name: str) -> list[bytes]:
    """The committed corpus of a reader."""
    return [path.read_bytes() for path in sorted((SEEDS / name).glob("*"))]


def kept(folder: Path, data: bytes) -> Path:
    """Write a case under the name of its hash."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / hashlib.sha1(data, usedforsecurity=False).hexdigest()[:16]
    path.write_bytes(data)
    return path


VALUES: tuple[Any, ...] = (None, True, -1, 0, 2, 10**400, 1e155, -1e13, 0.5, "", "x", "\x1b[2J", [], [[]], {}, {"x": 1})


def reshaped(dice: random.Random, data: bytes) -> bytes:
    """JSON with one entry changed, taken out or put elsewhere: what is behind the parser is reached."""
    try:
        record = json.loads(data)
    except (ValueError, RecursionError):
        return data
    places: list[tuple[Any, Any]] = []
    inner = [record]
    for one in inner:  # grows
        if isinstance(one, dict | list):
            places += [(one, key) for key in (one if isinstance(one, dict) else range(len(one)))]
            inner += one.values() if isinstance(one, dict) else one
    if not places:
        return data
    (holder, key), what = dice.choice(places), dice.randrange(4)
    if what == 0:
        del holder[key]
    elif what == 1:
        other, at = dice.choice(places)
        holder[key] = copy.deepcopy(other[at])
    elif isinstance(holder[key], float) and what == 2:
        holder[key] *= dice.choice((-1.0, 1.0 + 1e-9, 1.5, 1e9))
    else:
        holder[key] = dice.choice(VALUES)
    return json.dumps(record).encode()


def readdressed(dice: random.Random, data: bytes) -> bytes:
    """XML with the value of one attribute changed or taken from another: it stays XML."""
    found = list(re.finditer(rb'="([^"<>]*)"', data))
    if not found:
        return data
    one, other = dice.choice(found), dice.choice(found)
    value = dice.choice([other[1], b"nan", b"inf", b"1e308", b"1e155", b"-1e13", b"-1", b"0", b"9" * 40, b""])
    return data[: one.start(1)] + value + data[one.end(1) :]


def mutated(dice: random.Random, corpus: list[bytes]) -> bytes:
    """One case made of the corpus: bytes changed, taken out, doubled, two cases joined, numbers made extreme."""
    data = bytearray(dice.choice(corpus))
    shaped = readdressed if data.startswith(b"<") else reshaped
    if dice.randrange(2) and (other := shaped(dice, bytes(data))) != data:
        return other
    for _ in range(dice.randint(1, 6)):
        at, end = sorted(dice.randint(0, len(data)) for _ in range(2))
        end = min(end, at + dice.choice((1, 2, 8, 64)))
        what = dice.randrange(6)
        if what == 0:
            data[at:end] = bytes(dice.randrange(256) for _ in range(end - at))
        elif what == 1:
            del data[at:end]
        elif what == 2:
            data[at:at] = data[at:end] * dice.choice((1, 2, 50))
        elif what == 3:
            other = dice.choice(corpus)
            data[at:end] = other[dice.randint(0, len(other)) :][: dice.choice((1, 8, 64, 512))]
        elif what == 4:
            data[at:end] = dice.choice(EXTREME)
        elif data:
            data[at % len(data)] ^= 1 << dice.randrange(8)
    return bytes(data[: max(LONGEST, *map(len, corpus))])


def grown(dice: random.Random, data: bytes) -> bytes:
    """The case with a part of it repeated, a line or some bytes, up to a length of 10 kB to 1 MB."""
    lines = data.splitlines(keepends=True)
    wanted = int(10 ** dice.uniform(4, 6))
    if len(lines) > 2 and dice.randrange(2):
        at = dice.randrange(len(lines))
        part = lines[at]
        before, after = b"".join(lines[: at + 1]), b"".join(lines[at + 1 :])
    else:
        at = dice.randint(0, len(data))
        part = data[at : at + dice.choice((1, 4, 16, 64, 256))] or b"["
        before, after = data[:at], data[at:]
    return (before + part * (wanted // len(part)) + after)[:GROWN]


def case_of(name: str, seed: int, number: int, corpus: list[bytes]) -> bytes:
    """The case of this number: first the corpus as it is, then what is made of it."""
    if number < len(corpus):
        return corpus[number]
    dice = random.Random(f"{name} {seed} {number}")
    data = mutated(dice, corpus)
    if dice.randrange(ONE_IN) == 0:
        return grown(dice, data)
    return data


def used() -> tuple[float, int]:
    """Processor time [s], and the most memory at once [bytes], of this process or of one that it started."""
    mine, theirs = resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = mine.ru_utime + mine.ru_stime + theirs.ru_utime + theirs.ru_stime
    return seconds, 1024 * max(mine.ru_maxrss, theirs.ru_maxrss)


def serve(name: str, seed: int, first: int, end: int) -> None:
    """Read the cases of these numbers, and print of each what came of it, a line of JSON."""
    corpus = seeds(name) or [b""]
    told = sys.stdout
    with tempfile.TemporaryDirectory() as folder:
        read = readers(Path(folder))[name]
        with contextlib.suppress(Exception):
            judged(read, corpus[0])  # imports what is imported late
        _, at_rest = used()
        for number in range(first, end):
            before, _ = used()
            fault, taken = "", False
            try:
                taken = judged(read, case_of(name, seed, number, corpus))
            except Exception as error:
                fault = f"{type(error).__name__}: {error}"
            after, most = used()
            if after - before > SECONDS:
                fault = f"{after - before:.0f} s of the processor; {fault}"
            if most - at_rest > MEMORY:
                fault = f"{(most - at_rest) / 2**30:.1f} GB of memory; {fault}"
            print(json.dumps([number, taken, fault, after - before, most - at_rest]), file=told, flush=True)
            if most - at_rest > MEMORY:
                return  # the most memory of a process never falls: the next cases get a new one


def _pass_on(output: Iterable[str], lines: queue.SimpleQueue[str]) -> None:
    """Put each line of a process into the queue, and "" after the last."""
    for line in output:
        lines.put(line)
    lines.put("")


def answers(name: str, seed: int, first: int, end: int) -> Iterator[list[Any]]:
    """What came of the cases, in their order; one that ends or stops its process has failed, the next get another."""
    while first < end:
        command = [sys.executable, __file__, name, "--seed", str(seed), "--numbers", str(first), str(end)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            lines: queue.SimpleQueue[str] = queue.SimpleQueue()
            threading.Thread(target=_pass_on, args=(process.stdout, lines), daemon=True).start()
            while first < end:
                try:
                    line = lines.get(timeout=PATIENCE)
                except queue.Empty:
                    process.kill()
                    yield [first, False, f"no answer for {PATIENCE:g} s", PATIENCE, 0]
                    first += 1
                    break
                if line:
                    yield json.loads(line)
                    first += 1
                    continue
                if process.wait():
                    yield [first, False, f"the process ended with {process.returncode}", 0.0, 0]
                    first += 1
                break


def blind(name: str, cases: int, seed: int, found: Path) -> int:
    """So many mutated cases of one reader; returns how many failed."""
    corpus = seeds(name) or [b""]
    taken = failed = 0
    slowest = cpu = memory = 0.0
    for number, read, fault, seconds, most in answers(name, seed, 0, cases + len(corpus)):
        taken += read
        cpu += seconds
        slowest, memory = max(slowest, seconds), max(memory, most)
        if fault:
            failed += 1
            place = kept(found / name, case_of(name, seed, number, corpus))
            print(f"{name}: {place}: {fault}", file=sys.stderr)
    print(json.dumps({"reader": name, "engine": "blind", "cases": cases + len(corpus), "taken": taken, "failed": failed,
                      "slowest_s": round(slowest, 3), "memory_mb": round(memory / 2**20), "cpu_s": round(cpu, 1)}),
          flush=True)  # fmt: skip
    return failed


def guided(name: str, cases: int, seed: int, corpus: Path, found: Path) -> None:
    """The same by atheris; ends the process with libFuzzer's exit code."""
    import atheris

    with atheris.instrument_imports(include=["rankdrop"], enable_loader_override=False):
        folder = tempfile.mkdtemp(prefix="rankdrop-fuzz-")
        read = readers(Path(folder))[name]
        for data in seeds(name):
            judged(read, data)  # imports what is imported late
    for place in (corpus / name, found / name):
        place.mkdir(parents=True, exist_ok=True)
    arguments = [f"-runs={cases}", f"-seed={seed}", f"-max_len={LONGEST}", "-timeout=20", "-rss_limit_mb=2000",
                 "-print_final_stats=1", "-close_fd_mask=1", f"-artifact_prefix={found / name}/",
                 str(corpus / name)]  # fmt: skip
    if (SEEDS / name).is_dir():
        arguments.append(str(SEEDS / name))
    atheris.Setup([sys.argv[0], *arguments], lambda data: judged(read, data), enable_python_coverage=True)
    atheris.Fuzz()


def main(argv: list[str] | None = None) -> int:
    """The command line; 1 where a case failed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reader", nargs="?", choices=NAMES, help="which one; without it their names are printed")
    parser.add_argument("--cases", type=int, default=10_000, help="how many")
    parser.add_argument("--seed", type=int, default=1, help="of the mutations")
    parser.add_argument("--blind", action="store_true", help="without coverage, where atheris is missing")
    parser.add_argument("--corpus", type=Path, default=Path("build/fuzz/corpus"), help="what reached something new")
    parser.add_argument("--found", type=Path, default=Path("build/fuzz/found"), help="cases that failed")
    parser.add_argument("--numbers", type=int, nargs=2, help=argparse.SUPPRESS)  # of cases, for a process of `blind`
    given = parser.parse_args(argv)
    if given.numbers is not None:
        serve(given.reader, given.seed, *given.numbers)
        return 0
    if given.reader is None:
        print("\n".join(NAMES))
        return 0
    if given.blind:
        return 1 if blind(given.reader, given.cases, given.seed, given.found) else 0
    guided(given.reader, given.cases, given.seed, given.corpus, given.found)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
