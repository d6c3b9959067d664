"""`rankdrop escape`: which joints lead out of a singular configuration."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import FRAME, NO_OPTIONS, TCP, ArmOptions, Whole


def escape(
    robot: str,
    /,
    *,
    q: Annotated[str, Parameter(allow_leading_hyphen=True)],
    deg: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    arm: ArmOptions = NO_OPTIONS,
    frame: FRAME = None,
    tcp: TCP = None,
    step: float = 0.1,
    seed: Whole = 0,
    full: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    lie: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Find the joints that lead out of a singular configuration, and those that cannot.

    Which joint to move, which way and how far, inside the limits; whether the
    tool can be kept still. With --full per joint the order at which the lost
    singular value grows, its rate, and its size after the motion.

    For example:
        rankdrop escape pa10 --q 0,0,0,0,0,0,0
        rankdrop escape rcrrrr --q 0,0,0,0,0,0,0 --length-scale 1 --lie

    Exit code 0: not singular, or a way out was found; 3: singular and none was
    found; 2: bad input.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        q: One number per joint, separated by commas or blanks [rad, m]; pi/2, 30deg, 120mm are understood.
        deg: Angles without a unit are in degrees.
        frame: In whose axes motions are told: base, tool, or the link in which they are simplest.
        tcp: Tool point from the tip, in its axes: x,y,z or x,y,z,roll,pitch,yaw [m, rad]; 120mm, 30deg are understood.
        step: Length of the motions that are tried [rad; slides in length scales].
        seed: Of every random choice.
        full: Print what is lost, the joints to blame, and all tables: every joint, Hunt's cofactors, singular runs.
        lie: Print Gallardo-Alvarado and Rico-Martinez's procedure step by step, and where it goes wrong.
        json: Write the result to this file as well; - writes it to stdout in place of the text.
        quiet: No progress; results and errors only.
    """
    from rankdrop import explain
    from rankdrop.cli.arm import open_arm, parse_configuration
    from rankdrop.cli.terminal import check_targets, hand_over, print_sections, results, show, write_json
    from rankdrop.local import OrderedScrewSet, render, report
    from rankdrop.results import way_out_to_dict

    check_targets({"--json": json})
    model, task = open_arm(robot, arm, tcp, deg=deg)
    given = parse_configuration(q, model, deg=deg)
    found = explain(model, given, task, evaluations=0, seed=seed, step=step, frame=frame)
    procedure = report(OrderedScrewSet.of(model, found.q), seed) if lie else None

    def to_stdout() -> None:
        parts = ("summary", "escape", "lost", "blame", "numbers") if full else ("summary", "escape", "lost", "more")
        print_sections(found.sections(parts=parts, full=full))
        if procedure is not None:
            show(results(), ["", render(procedure)])

    hand_over(to_stdout, (json, lambda target: write_json(way_out_to_dict(found, procedure), target)))
    out = any(one.order is not None for one in found.escape.single) or found.escape.best_direction.restores
    return exits.FINE if out or not found.rank.corank else exits.UNEXPLAINED
