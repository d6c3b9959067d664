"""`rankdrop explain`: which singularity this is, what is lost, who is to blame, how to get out, how far it is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import FRAME, IDEAL, NO_OPTIONS, TCP, ArmOptions, Whole
from rankdrop.tolerances import EVALUATIONS, NEAR

if TYPE_CHECKING:
    from rankdrop.results import Explanation, Record
    from rankdrop.verbs import Here, Idealised


def explain(
    robot: str,
    /,
    *,
    q: Annotated[str, Parameter(allow_leading_hyphen=True)],
    deg: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    arm: ArmOptions = NO_OPTIONS,
    frame: FRAME = None,
    tcp: TCP = None,
    ideal: IDEAL = None,
    analysis: str | None = None,
    near: float = NEAR,
    speed: str | None = None,
    tolerance: float | None = None,
    limits: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    evaluations: Whole = EVALUATIONS,
    seed: Whole = 0,
    certificate: str | None = None,
    full: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Explain one configuration: is it singular, which one, what is lost, which joints, how to get out, how far.

    For example:
        rankdrop explain pa10 --q 0,0,0,0,0,0,0
        rankdrop explain ur5 --deg --q 0,-135,45,90,-90,0 --frame base --tcp 0,0,120mm
        rankdrop explain arm.urdf --tip flange --q "0.1 0.5 -1.2 0 pi/2 0" --json here.json

    Exit code 0: regular; 3: near a singularity; 4: singular, or the arm is
    deficient for the task at every configuration; 2: bad input.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        q: One number per joint, separated by commas or blanks [rad, m]; pi/2, 30deg, 120mm are understood.
        deg: Angles without a unit are in degrees.
        frame: In whose axes motions are told: base, tool, or the link in which they are simplest.
        tcp: Tool point from the tip, in its axes: x,y,z or x,y,z,roll,pitch,yaw [m, rad]; 120mm, 30deg are understood.
        ideal: The nearest arm whose axes are exactly parallel, square and meeting, to a tolerance such as 1mm,0.5deg.
            What the arm itself does where the ideal one is singular is told.
        analysis: Families from this file (`rankdrop analyze --json`); else from the catalogue, else found on the spot.
        near: Near a singularity: within this distance in joint space [rad].
        speed: … or where a straight motion of the tool is slower than this within the rate limits of the joints, such
            as 250mm/s or 250mm/s,20deg/s; else 25mm/s,5deg/s; 0 for none.
        tolerance: Singular values at or below it count as zero; else 1e-9.
        limits: The nearest singularity within the joint limits.
        evaluations: Budget of the certified radius; 0 for the quick one.
        seed: Of every random choice.
        certificate: Write what is proven to this file, for `rankdrop verify`: at a singular configuration that one
            exists there, else a ball without any.
        full: Print all sections: every circuit, ellipsoids, joint rates, redundancy, representation.
        json: Write the explanation to this file as well; - writes it to stdout in place of the text.
        quiet: No progress; results and errors only.
    """
    from dataclasses import replace

    from rankdrop import explain as run
    from rankdrop.cli.arm import open_ideal, parse_configuration, parse_speeds
    from rankdrop.cli.certificates import of_place, save_certificate
    from rankdrop.cli.terminal import check_targets, hand_over, interrupted, write_json
    from rankdrop.results import Analysis, plain
    from rankdrop.tolerances import DEFAULT
    from rankdrop.verbs import here

    check_targets({"--json": json, "--certificate": certificate})
    model, task, made = open_ideal(robot, arm, ideal, tcp, deg=deg)
    given = parse_configuration(q, model, deg=deg)
    found = run(
        model, given, task, analysis=None if analysis is None else Analysis.load(analysis), near=near, limits=limits,
        evaluations=evaluations, seed=seed, frame=frame, **parse_speeds(speed),
        tolerances=DEFAULT if tolerance is None else replace(DEFAULT, singular=tolerance),
    )  # fmt: skip
    beside = None if made is None else here(made, found)
    proven = None if certificate is None else of_place(found, None, evaluations)

    def record() -> Record:
        if made is None or beside is None:
            return found.to_dict()
        return found.to_dict() | {"ideal": {**made.to_dict(found.task), "here": plain(beside)}}

    hand_over(
        lambda: _print(found, made, beside, full=full),
        (json, lambda target: write_json(record(), target)),
        (certificate, lambda target: save_certificate(proven, target)),
    )
    return interrupted(found) or EXIT[found.verdict]


EXIT = {"regular": exits.FINE, "near": exits.NEAR, "singular": exits.SINGULAR, "always-singular": exits.SINGULAR}


def _print(explanation: Explanation, made: Idealised | None, beside: Here | None, *, full: bool) -> None:
    from rankdrop.cli.arm import near_line
    from rankdrop.cli.terminal import print_sections
    from rankdrop.sections import Section
    from rankdrop.verbs import here_section, moved_section

    first, *sections = explanation.sections(full=full)
    if made is not None and beside is not None:
        sections[:0] = [here_section(made, beside), *([moved_section(made)] if full else [])]
    sections += [Section("", "", (line,)) for line in near_line(explanation.robot, made).values()]
    print_sections([first, *sections])
