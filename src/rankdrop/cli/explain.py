"""`rankdrop explain`: which singularity this is, lost motion, joints to blame, how to get out, how far it is."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal

from rankdrop import cover as covers
from rankdrop import local, results, text, verbs
from rankdrop import robot as arms
from rankdrop.cli import exits
from rankdrop.cli.command import Done, Output, command
from rankdrop.cli.opening import NO_IDEAL, NO_TOOL, ROBOT, IdealOptions, ToolOptions, near_line, open_ideal
from rankdrop.cli.proof import in_words, of_place
from rankdrop.cli.terminal import fit_to_console, say
from rankdrop.cli.values import POSE, Q, joint_units, model_tolerance, parse_configuration, parse_pose
from rankdrop.errors import OptionError
from rankdrop.options import option
from rankdrop.questions import ExplainOptions
from rankdrop.sections import Section
from rankdrop.tolerances import DEFAULT, EVALUATIONS

if TYPE_CHECKING:
    from rankdrop.cli.terminal import Block

EXIT = {"regular": exits.FINE, "near": exits.NEAR, "singular": exits.SINGULAR, "always-singular": exits.SINGULAR}
STOPPED = "interrupted: the certified radius could have become larger"
BUDGET = {None: EVALUATIONS, "escape": 0, "nearest": 100_000}


@dataclass(frozen=True)
class ShownParts(Output):
    """Given data, and which parts of an explanation are printed or written."""

    analysis: Annotated[
        str | None,
        option("Families from this file (`rankdrop analyze --json`); else the catalogue's, else found on the spot"),
    ] = None
    tolerance: Annotated[float, option("Singular values at or below it count as zero; else 1e-9")] | None = None
    only: Annotated[
        Literal["escape", "nearest"] | None, option("One part: the joints that lead out, or distances and their proof")
    ] = None
    full: Annotated[bool, option("Print all sections and all tables")] = False
    lie: Annotated[
        bool, option("With --only escape: Gallardo-Alvarado and Rico-Martinez's procedure, and where it goes wrong")
    ] = False
    certificate: Annotated[
        str | None,
        option("File for `rankdrop verify`: the ball proven to be free, or the proof that q is singular", writes=()),
    ] = None
    model_tolerance: Annotated[
        str | None, option("The ball holds for every arm so near to this one, joint by joint: 0.3mm,1mrad")
    ] = None


@command
def explain(
    robot: ROBOT,
    /,
    *,
    q: Q | None = None,
    pose: POSE | None = None,
    tool: ToolOptions = NO_TOOL,
    options: ExplainOptions = ExplainOptions(),
    arm: IdealOptions = NO_IDEAL,
    output: ShownParts = ShownParts(),
) -> Done:
    """Explain a configuration: lost motion, ways out.

    With --only escape: the joints that lead out, which way and how far, and those that cannot. With --only nearest:
    the nearest singular configuration, found from many starts, and a radius proven to be free of any.

    With --pose instead of --q: every configuration found at a pose of the tip, with its verdict, posture and joint
    limits; or why there is none, and how far the pose is out of reach. The orientation is R = Rz(yaw) Ry(pitch)
    Rx(roll), or a unit quaternion. --task, --tcp, --deg and --seed apply.

    For example:
        rankdrop explain pa10 --q 0,0,0,0,0,0,0
        rankdrop explain ur5 --deg --q 0,-135,45,90,-90,0 --frame base --tcp 0,0,120mm
        rankdrop explain ur5 --deg --q 0,-135,45,90,-90,0 --only nearest --certificate here.json
        rankdrop explain irb120 --deg --pose 350mm,0,400mm,180,0,0
        rankdrop explain rcrrrr --q 0,0,0,0,0,0,0 --length-scale 1 --only escape --lie

    Exit code 0: regular; 3: near a singularity; 4: singular, or the arm is deficient for the task at every
    configuration. With --only escape 0: not singular, or a way out was found; 3: none. With --only nearest 0: one was
    found; 3: none. With --pose 0: a solution inside the joint limits was found; 3: none. 2: bad input.
    """
    from rankdrop import explain as run

    if q is not None and pose is not None:
        raise OptionError("--q and --pose exclude each other", allowed="one of them")
    if pose is not None:
        return _of_pose(robot, pose, arm, tool, options, output)

    near = model_tolerance(output.model_tolerance)
    model, task, idealised = open_ideal(robot, arm, tool)
    place = _place(q, model, tool)
    analysis, tolerances = None, DEFAULT
    if output.analysis is not None:
        analysis = results.Analysis.load(output.analysis)
    elif arm.task is None:
        task = local.asked_task(model, task)
    if output.tolerance is not None:
        tolerances = replace(DEFAULT, singular=output.tolerance)
    options = _for_parts(options, output.only)
    _refuse_analysis_of_ideal_arm(model, analysis)
    explanation = run(model, place, task, options, analysis=analysis, tolerances=tolerances)
    return _of_configuration(explanation, idealised, near, options, output)


def _refuse_analysis_of_ideal_arm(model: arms.Robot, analysis: results.Analysis | None) -> None:
    """Refuse an analysis of the ideal arm near this one, which `analyze` takes of its own accord.

    Raises:
        OptionError: with the option that takes the same arm.
    """
    if analysis is None or analysis.robot.name != arms.ideal_name(model):
        return
    near = arms.intended_tolerance(model)
    if near is None:
        same = "--ideal with the tolerance of the analysis"
    else:
        same = f"--ideal {near.text}"
    raise OptionError(
        "the analysis is about the ideal arm near this one", where="--analysis", got=analysis.robot.name,
        allowed=model.name, mend=f"{same}, or analyze the arm as written: analyze --ideal off",
    )


def _place(q: str | None, model: arms.Robot, tool: ToolOptions) -> list[float]:
    """The configuration as it was typed [rad, m].

    Raises:
        OptionError: none was typed, or it is not one of this arm.
    """
    if q is None:
        raise OptionError(
            "joint values are missing", where="--q", allowed=joint_units(model, deg=tool.deg),
            mend=f"--q {','.join('0' * model.n)}, or --pose for a pose of the tip",
        )  # fmt: skip
    return parse_configuration(q, model, deg=tool.deg)


def _of_configuration(
    explanation: results.Explanation, idealised: results.Idealised | None, near: covers.ModelTolerance | None,
    options: ExplainOptions, output: ShownParts,
) -> Done:  # fmt: skip
    """The explanation; with options also the ideal arm here, the certificate and the Lie procedure."""
    ideal_here = proven = procedure = None
    if idealised is not None:
        ideal_here = verbs.ideal_vs_actual_at(idealised, explanation)
    if output.certificate is not None or near is not None:
        proven = of_place(explanation, near, options.evaluations)
    if output.lie:
        procedure = local.report(local.OrderedScrewSet.of(explanation.robot, explanation.q), options.seed)

    def blocks() -> list[Block]:
        shown: list[Block] = [*_sections(explanation, idealised, ideal_here, output)]
        if proven is not None and output.only == "nearest":
            shown.append(Section("certificate", in_words(proven)))
        if procedure is not None:
            shown.append([text.procedure_text(procedure)])
        return shown

    files = {
        "json": lambda: _record(explanation, idealised, ideal_here, procedure, output.only),
        "certificate": lambda: proven,
    }
    if stopped_early(explanation):
        return Done(blocks, files, last=partial(say, STOPPED), code=exits.INTERRUPTED)
    return Done(blocks, files, code=_code(explanation, output.only))


def _for_parts(options: ExplainOptions, only: str | None) -> ExplainOptions:
    """The options for the parts that are asked for: how many enclosures, and up to which corank."""
    if options.evaluations == EVALUATIONS:
        options = replace(options, evaluations=BUDGET[only])
    if only == "nearest":
        options = replace(options, coranks=6)
    return options


def _of_pose(
    robot: str, words: str, arm: IdealOptions, tool: ToolOptions, options: ExplainOptions, output: ShownParts
) -> Done:
    """The solutions of the inverse at a pose."""
    from rankdrop import inverse

    given = {"--only": output.only, "--certificate": output.certificate, "--analysis": output.analysis,
             "--model-tolerance": output.model_tolerance, "--lie": output.lie or None}  # fmt: skip
    for name in [name for name, value in given.items() if value is not None][:1]:
        raise OptionError("this option is for one configuration", where=name, allowed="--q")
    model, task, _ = open_ideal(robot, arm, tool)
    solutions = inverse(model, parse_pose(words, deg=tool.deg, robot=model), task, seed=options.seed)
    return Done(
        lambda: solutions.sections(deg=tool.deg), {"json": solutions.to_dict},
        code=exits.FINE if solutions.inside else exits.UNEXPLAINED,
    )  # fmt: skip


def stopped_early(explanation: results.Explanation) -> bool:
    """Whether Ctrl-C ended the proof early; what was proven holds."""
    return explanation.far.certificate is not None and not explanation.far.certificate.complete


def _sections(
    explanation: results.Explanation, idealised: results.Idealised | None, ideal_here: results.Here | None,
    output: ShownParts,
) -> Iterable[Block]:
    if output.only == "nearest":
        if output.full:
            return explanation.sections(parts=("summary", "nearest", "numbers"), full=True)
        short = explanation.sections(parts=("summary", "nearest"))
        return fit_to_console(short, cut=[section for section in short if section.rows])
    if output.only == "escape":
        rest = ("lost", "blame", "numbers") if output.full else ("lost", "more")
        return explanation.sections(parts=("summary", "escape", *rest), full=output.full)
    more = explanation.sections(parts=("more",), full=output.full)
    first, *sections = (*explanation.sections(full=output.full), *more)
    if idealised is not None and ideal_here is not None:
        moved = [text.moved_section(idealised)] if output.full else []
        sections[:0] = [text.here_section(idealised, ideal_here), *moved]
    sections += [Section("", "", (line,)) for line in near_line(explanation.robot, idealised).values()]
    return [first, *sections]


def _record(
    explanation: results.Explanation, idealised: results.Idealised | None, ideal_here: results.Here | None,
    procedure: Any, only: str | None,
) -> dict[str, Any]:
    from rankdrop.codec import plain, record_of

    if only is not None:
        return record_of(only, explanation) | ({"lie": plain(procedure)} if only == "escape" else {})
    if idealised is None or ideal_here is None:
        nearby = {}
    else:
        nearby = {"ideal": {**idealised.to_dict(explanation.task), "here": plain(ideal_here)}}
    return explanation.to_dict() | nearby


def _code(explanation: results.Explanation, only: str | None) -> int:
    if only is None:
        return EXIT[explanation.verdict]
    out = any(way.order is not None for way in explanation.escape.single) or explanation.escape.best_direction.restores
    if only == "escape":
        fine = not explanation.rank.corank or out
    else:
        fine = explanation.far.nearest is not None or explanation.rank.corank > 0
    return exits.FINE if fine else exits.UNEXPLAINED
