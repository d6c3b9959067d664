"""What a user asks beside the conditions: is mine right, which aspect is this, what parts these two."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING

from rankdrop.errors import OptionError, RankdropError
from rankdrop.results import of_conditions

if TYPE_CHECKING:
    from rankdrop.exact import Chain, Flags
    from rankdrop.results import Conditions, Record, Verdict
    from rankdrop.robot import Robot
    from rankdrop.sections import Section


@dataclass(frozen=True)
class Question:
    """The options --test, --flags, --from and --to; false where none is given.

    Attributes:
        robot: the arm.
        test: a condition.
        flags, start, end: configurations as typed.
        deg: angles without a unit are in degrees.
    """

    robot: Robot
    test: str | None
    flags: str | None
    start: str | None
    end: str | None
    deg: bool

    def __bool__(self) -> bool:
        return any(one is not None for one in (self.test, self.flags, self.start, self.end))

    def check(self, chain: Chain) -> None:
        """Refuse bad input before the derivation.

        Raises:
            OptionError: a mistake in the condition, or one of --from and --to without the other.
            ConfigurationError: not a configuration.
            TaskError: flags of an arm whose Jacobian is not square.
        """
        if not self:
            return
        from rankdrop.exact import parse_conditions, signs_of

        if self.test is not None:
            parse_conditions(self.test, chain.ring, shifts=[float(shift) for shift in chain.shifts])
        if (self.start is None) != (self.end is None):
            missing, given = ("--from", "--to") if self.start is None else ("--to", "--from")
            raise OptionError(f"{given} needs {missing}", where=missing, mend="give both configurations")
        options = (("--flags", self.flags), ("--from", self.start), ("--to", self.end))
        typed = [(option, one) for option, one in options if one is not None]
        for option, one in typed:
            self._q(one, option)
        if typed:
            signs_of(chain, names=False)

    def answer(self, found: Conditions) -> tuple[list[Section], Record, Verdict]:
        """From what was derived: text, entries of the JSON, the verdict on the conditions and the one asked about."""
        sections: list[Section] = []
        record: Record = {"test": None, "flags": None, "between": None}
        tested = "exact"
        if self.test is not None:
            section, record["test"], tested = _tested(found, self.test)
            sections.append(section)
        if self.flags is not None:
            flags = found.flags(self._q(self.flags))
            record["flags"] = flags.to_dict()
            sections.append(self._flags("Configuration flags", flags))
        if self.start is not None and self.end is not None:
            between = found.between(self._q(self.start), self._q(self.end))
            record["between"] = between.to_dict()
            sections += [self._flags("From", between.first), self._flags("To", between.second)]
            sections.append(_section("What parts them", between.sentences()))
        verdict = of_conditions(found, tested)
        return sections, {**record, **verdict.to_dict()}, verdict

    def _q(self, text: str, option: str = "") -> list[float]:
        from rankdrop.cli.configuration import parse_configuration

        return parse_configuration(text, self.robot, deg=self.deg, option=option)

    def _flags(self, title: str, flags: Flags) -> Section:
        pairs = zip(flags.q, self.robot.variables, strict=True)
        shown = [degrees(x) if self.deg and joint.unit == "rad" else x for x, joint in pairs]
        values = ", ".join(f"{round(x, 12) + 0.0:.6g}".replace("-", "−") for x in shown)
        return _section(title, flags.sentences(), f"q = ({values}) [{'°' if self.deg else 'rad'}, m]")


def _tested(found: Conditions, condition: str) -> tuple[Section, Record | None, str]:
    try:
        result = found.test(condition)
    except RankdropError as error:  # the derivation ended early: what it has is shown all the same
        return _section("Your condition", (f"not tested: {error}",), condition), None, "not tested"
    return _section("Your condition", result.sentences(), condition), result.to_dict(), result.verdict


def _section(title: str, lines: tuple[str, ...], summary: str = "") -> Section:
    from rankdrop.sections import Section

    return Section(title, summary, lines)
