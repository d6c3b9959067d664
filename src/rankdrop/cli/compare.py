"""`rankdrop compare`: arms side by side for the same task."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import Whole

if TYPE_CHECKING:
    from rankdrop.designs import SideBySide


def compare(
    *arms: str,
    task: str | None = None,
    within: str = "5deg",
    lower: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    upper: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    rpy: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    points: Whole = 100,
    path: tuple[str, ...] = (),
    certified: str | None = None,
    limits: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    length_scale: float | None = None,
    as_written: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    starts: Whole = 1000,
    seed: Whole = 0,
    workers: Whole = 0,
    scheduler: str | None = None,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Two to ten arms side by side for the same task, by the same measures.

    Families, the share of the joint space near them, and where asked for: σ over
    a box of the workspace, on tool paths, and the share proven free. σ is
    divided by one length scale for all of them.

    For example:
        rankdrop compare ur5e gp7 irb1200
        rankdrop compare ur5 my_arm.urdf --limits --within 10deg
        rankdrop compare ur5e ur10e --lower 0.3,-0.3,0.1 --upper 0.6,0.3,0.5 --rpy 180deg,0,0
        rankdrop compare ur5e crx10ia --path weld.csv --json arms.json

    Exit code 0: every arm was measured, its families verified; 3: some were not;
    2: bad input.

    Args:
        arms: Names in the catalogue (`rankdrop robots`) or files.
        task: pose, position, orientation, planar, planar-position, scara, or rows (vx,vy,wz). Default: the first arm's.
        within: Tell the share of the joint space within this distance of singularities; 0.1 is rad.
        lower: Corner of a box of the workspace, in the base frame: x,y,z [m]; 300mm is understood.
        upper: The opposite corner.
        rpy: Orientation of the tool in the box: roll,pitch,yaw. Default: any.
        points: Poses looked at in the box.
        path: File of tool poses (see `rankdrop path`). May be given again.
        certified: Prove free what can be, with boxes of this width, such as 0.2; takes seconds to minutes an arm.
        limits: Within the joint limits only.
        length_scale: Translation rows are divided by it for every arm [m]. Default: the largest reach among them.
        as_written: Keep the files' numbers: 1.5708 is not a right angle then.
        starts: Random starts for each corank.
        seed: Of every random choice; the same seed gives the same result.
        workers: Local processes; 0: one for every processor. The result does not depend on it.
        scheduler: Address of a Dask scheduler, whose workers do the work (tcp://HOST:8786).
        json: Write the result to this file as well; - writes it to stdout in place of the text.
        quiet: No progress.
    """
    from rankdrop.cli.terminal import check_targets, hand_over, reporter, write_json
    from rankdrop.designs import asks_of, side_by_side

    check_targets({"--json": json})
    asked: dict[str, Any] = {"families": {"starts": starts, "fresh": 1000}, "near": {"within": within}}
    if lower is not None or upper is not None:
        asked["region"] = {"lower": _three(lower, "--lower"), "upper": _three(upper, "--upper"), "points": points}
        asked["region"] |= {} if rpy is None else {"rpy": _three(rpy, "--rpy")}
    if path:
        asked["paths"] = {"files": list(path)}
    if certified is not None:
        asked["certified"] = {"width": certified}
    asks = asks_of(asked, file="the command line")
    with reporter(quiet=quiet) as report:
        found = side_by_side(
            arms, asks, task=task, length_scale=length_scale, limits=limits, seed=seed, as_written=as_written,
            workers=workers, scheduler=scheduler, report=report,
        )  # fmt: skip
    hand_over(lambda: _print(found), (json, lambda target: write_json(found.to_dict(), target)))
    return exits.FINE if found.holds else exits.UNEXPLAINED


def _three(text: str | None, option: str) -> list[float | str]:
    from rankdrop.errors import OptionError

    words = [] if text is None else [word.strip() for word in text.split(",")]
    if len(words) != 3:
        raise OptionError("it is three numbers", where=option, got=text, allowed="such as 0.3,-0.3,0.1")
    return list(words)


def _print(designs: SideBySide) -> None:
    from rankdrop.cli.terminal import print_sections

    print_sections(designs.sections())
