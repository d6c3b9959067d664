"""Remedies of `rankdrop path`: the options, what is printed, and the mended file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

if TYPE_CHECKING:
    from rankdrop.cli.terminal import Report
    from rankdrop.motion import Mending, PathCheck
    from rankdrop.results import Analysis


@Parameter(name="*")
@dataclass(frozen=True)
class MendOptions:
    """Options of the remedies."""

    remedies: Annotated[bool, Parameter(negative=(), show_default=False)] = False
    """What would mend the path, each computed, judged again and proven."""
    tool_tilt: str = "0"
    """The tool may be tilted by up to this angle: 10deg. Asks for --remedies; so do the four below."""
    base_shift: str = "0"
    """The base may be moved by up to this length: 50mm."""
    blend: str = "0"
    """Where a corner is cut the tool point may leave the path by up to this length: 5mm."""
    acceleration: str | None = None
    """Limit of joint accelerations [rad/s², m/s²], for new time laws; arms state none."""
    fixed: str | None = None
    """Write the first path that is mended and proven free here, or retimed: .csv, .npz, .json."""

    @property
    def asked(self) -> bool:
        """Whether any of them is given."""
        return self.remedies or self != NO_MENDING


NO_MENDING = MendOptions()


def check_options(options: MendOptions, several: bool) -> dict[str, float | None]:
    """The bounds as numbers, before any work.

    Raises:
        OptionError: a number that cannot be, or several paths.
    """
    from rankdrop.errors import OptionError, RobotError
    from rankdrop.robot import quantity

    if options.asked and several:
        raise OptionError("remedies are those of one path", where="--remedies", mend="name one file, without --out")
    bounds: dict[str, float | None] = {}
    for name, text, measure in (("tool_tilt", options.tool_tilt, "angle"), ("base_shift", options.base_shift, "length"),
                                ("blend", options.blend, "length"),
                                ("acceleration", options.acceleration, "number")):  # fmt: skip
        where = "--" + name.replace("_", "-")
        try:
            bounds[name] = None if text is None else quantity(text, measure, where=where)
        except RobotError as error:
            raise OptionError(error.what, where=error.where, got=error.got, allowed=error.allowed) from error
        value = bounds[name]
        if value is not None and (value < 0.0 or (name == "acceleration" and value == 0.0)):
            least = "above 0" if name == "acceleration" else "0 or more"
            raise OptionError("the bound is out of range", where=where, got=text, allowed=least)
    return bounds


def mended(
    result: PathCheck, bounds: dict[str, float | None], analysis: Analysis | None, report: Report
) -> Mending:
    """The remedies, with progress."""
    from rankdrop.motion import mend_path

    return mend_path(
        result, analysis=analysis, tool_tilt=bounds["tool_tilt"] or 0.0, base_shift=bounds["base_shift"] or 0.0,
        blend=bounds["blend"] or 0.0, acceleration=bounds["acceleration"],
        progress=lambda kind, done, total: report(f"remedies: {kind}", done, total),
    )  # fmt: skip


def write_fixed(mending: Mending, target: str) -> None:
    """The mended path as a file, and a line that says so."""
    from rankdrop.cli.terminal import say, write_bytes
    from rankdrop.motion import trajectory_bytes

    one = mending.best or (mending.remedies[0] if mending.remedies else None)
    if one is None:
        say(f"{target} is not written: {'no remedy was found' if mending.needed else 'the path needs none'}")
        return
    write_bytes(trajectory_bytes(one.trajectory, mending.before.robot, target), target)
    between = "" if one.interpolate == "linear" else f", read it with --interpolate {one.interpolate}"
    say(f"{target}: mended by {one.kind}, judged again: {one.check.verdict}{between}")
