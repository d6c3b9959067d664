"""Compare two records of tools/record_outputs.py: what differs, per command and kind of sentence.

    .venv/bin/python tools/compare_outputs.py before after
    .venv/bin/python tools/compare_outputs.py before after --tolerance 1e-9 --examples 3

A kind of sentence is a line with its numbers taken out; a kind of entry is a place in a JSON file with its indices
taken out. Each kind is told once: how often it went, how often it came, in how many arms, with an example. Arms that
only one of the two records holds are named, and not compared. Exit code 1 where anything differs by more than the
tolerance.
"""

from __future__ import annotations

import argparse
import difflib
import json
import re
import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

_NUMBER = re.compile(r"(?<![\w#])[−+-]?\d[\d,]*(?:\.\d+)?(?:e[−+-]?\d+)?")
_MISSING = "(no such entry)"


@dataclass
class Kind:
    """All differences of one kind.

    Attributes:
        went: how many lines or entries are in the first record only.
        came: in the second only.
        arms: folders it was met in.
        examples: (folder, before, after); "" where there is nothing.
    """

    went: int = 0
    came: int = 0
    arms: set[str] = field(default_factory=set)
    examples: list[tuple[str, str, str]] = field(default_factory=list)


Kinds = dict[tuple[str, str], Kind]
"""(command, kind) -> what differs."""


def kind_of(line: str) -> str:
    """A line with its numbers, and the rules and gaps of tables, taken out."""
    return re.sub(r"\s+", " ", re.sub(r"[─═╌-]{4,}", "─", _NUMBER.sub("#", line))).strip()


def lines_differ(before: str, after: str) -> Iterator[tuple[str, str]]:
    """(line before, line after) where two texts differ; "" where one has none. Whole words of moved lines count."""
    old, new = before.splitlines(), after.splitlines()
    matcher = difflib.SequenceMatcher(None, old, new, autojunk=False)
    for tag, a, b, c, d in matcher.get_opcodes():
        if tag == "equal":
            continue
        left, right = old[a:b], new[c:d]
        for one in left:
            same = next((other for other in right if kind_of(other) == kind_of(one)), None)
            if same is not None:
                right.remove(same)
            yield one, same or ""
        yield from (("", other) for other in right)


def entries_differ(before: object, after: object, tolerance: float, place: str = "") -> Iterator[tuple[str, str, str]]:
    """(place, value before, value after) where two JSON values differ; numbers by more than tolerance × (1 + size)."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key in [*before, *(key for key in after if key not in before)]:
            yield from entries_differ(before.get(key, _MISSING), after.get(key, _MISSING), tolerance, f"{place}.{key}")
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for one, other in zip(before, after, strict=True):
            yield from entries_differ(one, other, tolerance, f"{place}[]")
    elif _number(before) and _number(after):
        if abs(before - after) > tolerance * (1 + abs(before)):  # type: ignore[operator, arg-type]
            yield place, repr(before), repr(after)
    elif before != after or type(before) is not type(after):
        yield place, _short(before), _short(after)


def _number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _short(value: object) -> str:
    return value if value == _MISSING else json.dumps(value, ensure_ascii=False)  # type: ignore[return-value]


def compare(before: Path, after: Path, tolerance: float = 0.0) -> Kinds:
    """All that differs between two folders, of the arms that both have.

    Args:
        before, after: folders that tools/record_outputs.py wrote.
        tolerance: numbers in JSON files may differ by this, times 1 + their size.

    Returns:
        For each command and kind, what differs.

    Raises:
        SystemExit: a folder is not there, or holds no record.
    """
    both = arms(before) & arms(after)
    files = {
        side: {path.relative_to(side) for arm in both for path in (side / arm).iterdir()} for side in (before, after)
    }
    kinds: Kinds = defaultdict(Kind)
    for path in sorted(files[before] | files[after]):
        one, other = before / path, after / path
        arm, command = path.parts[0], path.name
        if path not in files[before] or path not in files[after]:
            there = path in files[before]
            _add(kinds[command, "(whole file)"], arm, "there" if there else "", "" if there else "there")
            continue
        texts = one.read_text(encoding="utf-8"), other.read_text(encoding="utf-8")
        if texts[0] == texts[1]:
            continue
        if path.suffix == ".json":
            for place, left, right in entries_differ(json.loads(texts[0]), json.loads(texts[1]), tolerance):
                _add(kinds[command, place or "(all)"], arm, left, right)
        else:
            for left, right in lines_differ(*texts):
                _add(kinds[command, kind_of(left or right)], arm, left.strip(), right.strip())
    return dict(kinds)


def arms(folder: Path) -> set[str]:
    """Names of the arms a record holds.

    Raises:
        SystemExit: there is no record.
    """
    found = {path.name for path in folder.iterdir() if path.is_dir()} if folder.is_dir() else set()
    if not found:
        raise SystemExit(f"{folder}: no record there; tools/record_outputs.py {folder} makes one")
    return found


def _add(kind: Kind, arm: str, before: str, after: str) -> None:
    kind.went += bool(before)
    kind.came += bool(after)
    kind.arms.add(arm)
    kind.examples.append((arm, before, after))


def report(kinds: Kinds, examples: int) -> Iterator[str]:
    """The differences as lines: commands in order, the most frequent kind first."""
    for command in sorted({command for command, _ in kinds}):
        of_it = {kind: found for (one, kind), found in kinds.items() if one == command}
        yield f"{command}: {len(of_it)} kinds of difference"
        for kind, found in sorted(of_it.items(), key=lambda item: -(item[1].went + item[1].came)):
            yield f"  {kind[:150]}   −{found.went} +{found.came}, {len(found.arms)} arms"
            for arm, before, after in found.examples[:examples]:
                yield from (f"      {arm}  {sign} {text[:300]}" for sign, text in (("−", before), ("+", after)) if text)


def main(arguments: list[str]) -> int:
    """Compare two records and print what differs."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("before", type=Path)
    reader.add_argument("after", type=Path)
    reader.add_argument("--tolerance", type=float, default=0.0, help="of numbers in JSON files; default 0")
    reader.add_argument("--examples", type=int, default=1, help="for each kind; default 1")
    asked = reader.parse_args(arguments)
    kinds = compare(asked.before, asked.after, asked.tolerance)
    for line in report(kinds, asked.examples):
        print(line)
    held = {side: arms(side) for side in (asked.before, asked.after)}
    for side, other in ((asked.before, asked.after), (asked.after, asked.before)):
        if alone := sorted(held[side] - held[other]):
            print(f"only in {side}, not compared: {', '.join(alone)}")
    number = len(held[asked.before] & held[asked.after])
    print(f"{number} arms compared: {f'{len(kinds)} kinds of difference' if kinds else 'the same'}")
    return 1 if kinds else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
