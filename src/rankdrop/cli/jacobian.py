"""`rankdrop jacobian`: the Jacobian seen from a link, closed or at a configuration, and its inverse."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ArmOptions, Whole

_FILE = Annotated[str | None, Parameter(allow_leading_hyphen=True)]
_SWITCH = Parameter(negative=(), show_default=False)


def jacobian(
    robot: str,
    /,
    *,
    frame: Whole | None = None,
    at: str = "tip",
    q: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    deg: Annotated[bool, _SWITCH] = False,
    symbolic: Annotated[bool, _SWITCH] = False,
    inverse: Annotated[bool, _SWITCH] = False,
    arm: ArmOptions = NO_OPTIONS,
    lengths: str = "auto",
    time_limit: float = 60.0,
    latex: _FILE = None,
    json: _FILE = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Write the Jacobian as it is seen from a link, its closed inverse, and which frame makes it shortest.

    In closed form, with letters for the lengths where that is possible; with
    --q in numbers, with --q and --symbolic both. The linear part is the
    velocity of the tip, or with --at of the point of the end effector that is
    at the origin of a link's frame.

    For example:
        rankdrop jacobian planar2r --frame 1 --inverse
        rankdrop jacobian canadarm2 --frame 5 --at 5
        rankdrop jacobian puma560 --frame 3 --at 5 --inverse --latex puma.tex
        rankdrop jacobian ur5 --frame 4 --deg --q 0,-90,60,0,80,0 --inverse

    Exit code 0: all checks hold; 3: one fails, or there is no inverse because
    the configuration is singular; 2: bad input.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        frame: Link whose axes are taken, from 1: z along its joint's axis, x along the common normal after it. Else the
            one that makes the matrix shortest.
        at: Reference point: tip, or a link from 1: the origin of its frame.
        q: A configuration [rad, m]; pi/2, 30deg, 120mm are understood.
        deg: Angles without a unit are in degrees.
        symbolic: The closed form beside the numbers of --q.
        inverse: The inverse as well, for as many rows as joints.
        lengths: auto, letters, numbers, or letters with their values: "a=0.635,d=120mm".
        time_limit: Seconds for the closed inverse.
        latex: Write the closed forms as LaTeX to this file; - for stdout in place of the text.
        json: Write everything as JSON.
        quiet: No progress.
    """
    from rankdrop.cli.arm import open_arm, parse_configuration
    from rankdrop.cli.conditions import lengths_of
    from rankdrop.cli.terminal import check_targets, hand_over, print_sections, write_json, write_text
    from rankdrop.errors import OptionError
    from rankdrop.verbs import link_jacobian

    check_targets({"--latex": latex, "--json": json})
    if latex is not None and q is not None and not symbolic:
        raise OptionError("numbers are not written as LaTeX", where="--latex", mend="give --symbolic as well")
    model, task = open_arm(robot, arm)
    given = None if q is None else parse_configuration(q, model, deg=deg)
    found = link_jacobian(
        model, frame, task, at=_point(at), q=given, symbolic=symbolic or given is None, inverse=inverse,
        lengths=lengths_of(lengths), seconds=time_limit / 3.0,
    )  # fmt: skip
    hand_over(
        lambda: print_sections(found.sections()),
        (latex, lambda target: write_text(found.latex(), target)),
        (json, lambda target: write_json(found.to_dict(), target)),
    )
    missing = inverse and found.numbers is not None and found.numbers.inverse is None
    return exits.FINE if found.holds and not missing else exits.UNEXPLAINED


def _point(text: str) -> int | None:
    """What --at says: None for the tip.

    Raises:
        OptionError: neither "tip" nor a number.
    """
    from rankdrop.errors import OptionError

    if text.strip() == "tip":
        return None
    if not text.strip().isdecimal():
        raise OptionError("this is no reference point", where="--at", got=repr(text), allowed="tip, or a link from 1")
    return int(text)
