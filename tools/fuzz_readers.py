"""Hostile files for every reader: whatever the bytes are, a reader gives what it is to give, or says what is wrong.

    .venv/bin/python tools/fuzz_readers.py robot --cases 100000      # one reader; needs the package atheris
    .venv/bin/python tools/fuzz_readers.py --blind trajectory        # without coverage: Python alone
    .ci/fuzz 20000                                                   # every reader, so many cases each

Guided by coverage of the package (atheris, a libFuzzer for Python); what reached something new is kept in --corpus, and
what failed in --found. `tests/data/fuzz` holds a small corpus of each reader, which `tests/robot/test_fuzz.py` reads
again in every run. Exit code 1 where a case fails.
"""

from __future__ import annotations

import argparse
import contextlib
import copy
import hashlib
import json
import random
import re
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

SEEDS = Path(__file__).resolve().parents[1] / "tests" / "data" / "fuzz"
LONGEST = 4096  # bytes of a case
EXTREME = (b"1e308", b"-1", b"nan", b"inf", b"1e-320", b"9" * 40, b"\x00", b"\x1b[2J", b"[" * 99)
NAMES = ("robot", "quantity", "configuration", "tolerance", "csv", "message", "yaml", "npy", "poses", "poses-json",
         "poses-yaml", "analysis", "cover", "certificate", "spec", "mjcf")  # fmt: skip


def readers(folder: Path) -> dict[str, Callable[[bytes], object]]:
    """Each reader by name: it takes the bytes of a file, written into `folder`, and may raise RankdropError."""
    from rankdrop.cli.command import parse_configuration
    from rankdrop.cover import verify
    from rankdrop.cover.covering import load_covering
    from rankdrop.designs.spec import read_spec
    from rankdrop.kinematics import jacobian, pose
    from rankdrop.path.read.files import holds_poses, read_poses, read_trajectory
    from rankdrop.proof.record import sealed
    from rankdrop.results.analysis import Analysis
    from rankdrop.robot.ideal import read_tolerance
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
            data = json.dumps(sealed(record) if isinstance(record, dict) else record).encode()
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

    found = (robot(".txt"), number, configuration, lambda data: read_tolerance(data.decode("utf-8", "replace")),
             trajectory(".csv"), trajectory(".json"), trajectory(".yaml"), trajectory(".npy"),
             poses(".csv"), poses(".json"), poses(".yaml"), lambda data: Analysis.load(written(data, ".json")),
             lambda data: load_covering(written(data, ".cover")), certificate,
             lambda data: read_spec(written(data, ".toml")), robot(".xml"))  # fmt: skip
    return dict(zip(NAMES, found, strict=True))


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
    return bytes(data[:LONGEST])


def blind(name: str, cases: int, seed: int, found: Path) -> int:
    """So many mutated cases of one reader; returns how many failed."""
    dice, corpus = random.Random(f"{name} {seed}"), seeds(name) or [b""]
    taken = failed = 0
    slowest, begin = 0.0, time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        read = readers(Path(folder))[name]
        for data in [*corpus, *(mutated(dice, corpus) for _ in range(cases))]:
            start = time.process_time()
            try:
                taken += judged(read, data)
            except Exception as error:
                failed += 1
                print(f"{name}: {kept(found / name, data)}: {type(error).__name__}: {error}", file=sys.stderr)
            slowest = max(slowest, time.process_time() - start)
    print(json.dumps({"reader": name, "engine": "blind", "cases": cases + len(corpus), "taken": taken, "failed": failed,
                      "slowest_s": round(slowest, 3), "cpu_s": round(time.process_time() - begin, 1)}))  # fmt: skip
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
    given = parser.parse_args(argv)
    if given.reader is None:
        print("\n".join(NAMES))
        return 0
    if given.blind:
        return 1 if blind(given.reader, given.cases, given.seed, given.found) else 0
    guided(given.reader, given.cases, given.seed, given.corpus, given.found)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
