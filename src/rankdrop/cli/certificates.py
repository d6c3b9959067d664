"""What --certificate and --model-tolerance do on the commands that prove something."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rankdrop.cli.terminal import STDOUT, write_json

if TYPE_CHECKING:
    from rankdrop.certify import ModelTolerance
    from rankdrop.results import Explanation


def model_tolerance(text: str | None) -> ModelTolerance | None:
    """A tolerance as it is typed: 0.3mm,1mrad; one of the two alone leaves the other at zero.

    Raises:
        OptionError: not a length, an angle or both; or an angle too large.
    """
    if text is None:
        return None
    from rankdrop.certify import ModelTolerance
    from rankdrop.robot import read_tolerance

    given = read_tolerance(text, where="--model-tolerance")
    return ModelTolerance(given.length or 0.0, given.angle or 0.0)


def of_place(explanation: Explanation, tolerance: ModelTolerance | None, evaluations: int) -> dict[str, Any]:
    """What can be proven at a configuration: that a singular one exists there, or a ball without any.

    Raises:
        OptionError: nothing can.
    """
    from rankdrop.certify import ball_certificate, existence_certificate

    if explanation.rank.corank and tolerance is None:
        return existence_certificate(explanation.robot, explanation.q, explanation.task)
    return ball_certificate(
        explanation.robot, explanation.q, explanation.task, tolerance=tolerance, evaluations=max(evaluations, 1)
    )


def in_words(record: dict[str, Any]) -> str:
    """One line: what the certificate claims."""
    from rankdrop.results import angle_below

    claim, near = record["claim"], record["tolerance"]
    if record["kind"] == "existence":
        return f"a singular configuration exists within {claim['radius']:.1g} of q, joint by joint"
    said = f"no singularity within {angle_below(claim['radius'])}"
    if near is None:
        return said
    return f"{said}, for every arm within {near['length'] * 1e3:g} mm and {near['angle'] * 1e3:g} mrad, joint by joint"


def save_certificate(record: dict[str, Any] | None, target: str) -> None:
    """Write a certificate where something was proven; to stdout when `target` is "-"."""
    from rankdrop.certify import write_certificate

    if record is not None and target == STDOUT:
        write_json(record, target)
    elif record is not None:
        write_certificate(record, target)
