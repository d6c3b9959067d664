"""What readers accept at most: sizes, counts, depth and ranges. The page docs/limits.md shows them.

A file beyond one of them is refused with its name before the work that the limit is there to spare.
"""

from __future__ import annotations

LARGEST_FILE = 50 * 2**20
"""Bytes of an XML file, a trajectory or a result; the largest robot descriptions in use are below 1 MB."""
LARGEST_TABLE = 2**20
"""Bytes of a TOML file or a list of screws; the largest table of the catalogue has 6 kB."""
DEEPEST = 100
"""Elements of XML, or lists and objects of YAML, inside one another."""
MOST_ELEMENTS = 200_000
"""Of an XML file; a humanoid with its meshes has some 2,000."""
MOST_BODIES = 20_000
"""Elements of an MJCF file: MuJoCo compiles all of it, whatever the chain."""
MOST_JOINTS = 200
"""Moving joints of a chain; no arm is longer."""
MOST_STEPS = 5_000
"""Joints of a chain, those that do not move included."""
DOTS = 4_000_000
"""Sum over the lines of a TOML file of (dots in the line)²: what its keys with dots can cost the parser."""
MOST_ROWS = 1_000_000
"""Rows of a trajectory."""
LARGEST_YAML = 2 * 2**20
"""Bytes of a trajectory in YAML, which is read a hundred times more slowly than JSON."""
LARGEST_ARRAY = 500 * 2**20
"""Bytes of an array in NumPy's files; a million rows of twenty joints have a third of it."""
LONGEST_HEAD = 200
"""Characters of the name of a column."""
LONGEST_TEXT = 200
"""Characters of a number as text: arithmetic with its unit."""

LARGEST_LENGTH = 1e12
"""[m]; no arm is longer, one given in µm has no larger number, and squares beyond the doubles are far away."""
LARGEST_ANGLE = 1e6
"""[rad]; beyond it neighbouring doubles are more than 1e-10 rad apart."""
LARGEST_TIME = 1e12
"""[s] of a trajectory; clocks that count from 1970 are at 2e9."""
LARGEST_NUMBER = 1e100
"""Of an entry of an axis or a screw: its square is still a double."""
RANGE = {"angle": LARGEST_ANGLE, "length": LARGEST_LENGTH, "number": LARGEST_NUMBER}
_UNIT = {"angle": " rad", "length": " m", "number": ""}


def allowed_range(measure: str, *, rate: bool = False) -> str:
    """The range of an angle, a length or a number, in words.

    Example:
        >>> allowed_range("angle"), allowed_range("length", rate=True)
        ('-1e+06 … 1e+06 rad', '-1e+12 … 1e+12 m/s')
    """
    most = RANGE[measure]
    return f"-{most:g} … {most:g}{_UNIT[measure]}{'/s' if rate else ''}"
