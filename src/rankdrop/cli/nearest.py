"""`rankdrop nearest`: how far the next singularity is, and a radius proven free of any."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from rankdrop.cli import exits
from rankdrop.cli.arm import NO_OPTIONS, ArmOptions, Whole


def nearest(
    robot: str,
    /,
    *,
    q: Annotated[str, Parameter(allow_leading_hyphen=True)],
    deg: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    arm: ArmOptions = NO_OPTIONS,
    analysis: str | None = None,
    limits: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    evaluations: Whole = 100_000,
    seed: Whole = 0,
    certificate: str | None = None,
    model_tolerance: str | None = None,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Find the singular configuration nearest to a given one, and prove how much room there is.

    Distances are Euclidean in joint space [rad; slides divided by the length
    scale]. The nearest one comes from many starts and may be missed; the
    certified radius is a proof, and never larger than the true distance.

    For example:
        rankdrop nearest ur5 --deg --q 0,-135,45,90,-90,0
        rankdrop nearest pa10 --q 0,0.5,0.3,1.2,0,0.7,0 --json far.json
        rankdrop nearest ur5 --deg --q 0,-135,45,90,-90,0 --certificate here.json --model-tolerance 0.3mm,1mrad

    Exit code 0: one was found; 3: none was found; 2: bad input.

    Args:
        robot: Name in the catalogue (`rankdrop robots`) or file (.urdf, .xacro, .xml, .toml).
        q: One number per joint, separated by commas or blanks [rad, m]; pi/2, 30deg, 120mm are understood.
        deg: Angles without a unit are in degrees.
        analysis: Families from this file (`rankdrop analyze --json`); else from the catalogue.
        limits: Within the joint limits.
        evaluations: Budget of the certified radius; about 2 microseconds each.
        seed: Of every random choice.
        certificate: Write what is proven to this file, for `rankdrop verify`: a ball of nearly the certified radius,
            cut into boxes that are quickly checked; at a singular configuration that one exists there.
        model_tolerance: Prove a ball for every arm so near to this one, joint by joint: 0.3mm,1mrad.
        json: Write the result to this file as well; - writes it to stdout in place of the text.
        quiet: No progress; results and errors only.
    """
    from rankdrop import explain
    from rankdrop.cli.arm import open_arm, parse_configuration
    from rankdrop.cli.certificates import in_words, of_place, save_certificate
    from rankdrop.cli.certificates import model_tolerance as tolerance_of
    from rankdrop.cli.terminal import check_targets, hand_over, interrupted, print_sections, write_json
    from rankdrop.results import Analysis, far_to_dict
    from rankdrop.sections import Section

    check_targets({"--json": json, "--certificate": certificate})
    near = tolerance_of(model_tolerance)
    model, task = open_arm(robot, arm)
    found = explain(
        model, parse_configuration(q, model, deg=deg), task, limits=limits, evaluations=evaluations, seed=seed,
        coranks=6, analysis=None if analysis is None else Analysis.load(analysis),
    )  # fmt: skip
    proven = of_place(found, near, evaluations) if certificate is not None or near is not None else None
    said = [] if proven is None else [Section("certificate", in_words(proven))]
    hand_over(
        lambda: print_sections([*found.sections(parts=("summary", "far", "numbers"), full=True), *said]),
        (certificate, lambda target: save_certificate(proven, target)),
        (json, lambda target: write_json(far_to_dict(found), target)),
    )
    known = found.far.nearest is not None or found.rank.corank
    return interrupted(found) or (exits.FINE if known else exits.UNEXPLAINED)
