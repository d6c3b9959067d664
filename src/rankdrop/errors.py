"""One base error. Every error says in one line: what is wrong, where, what was got, what is allowed, how to mend it."""

from __future__ import annotations

from collections.abc import Container
from typing import Any

_MARKS = (0x200E, 0x200F, *range(0x2028, 0x202F), *range(0x2066, 0x206A), 0xFEFF)  # they turn the direction of writing
HIDDEN = {
    **{code: chr(0x2400 + code) for code in range(0x20) if chr(code) not in "\n\t"},
    0x7F: "\u2421",
    **dict.fromkeys((*range(0x80, 0xA0), *_MARKS), "\ufffd"),
}
"""For `str.translate`: what would steer a terminal -> a sign in its place."""
_LONGEST_PART = 2000  # characters of one part of an error: a name may have as many as its file
_LONGEST_ECHO = 200  # characters of a value that was given


def visible(text: str) -> str:
    """A text from outside as it may reach a terminal: what would steer the terminal is shown as a sign instead.

    Control characters become their Unicode pictures (␛ for escape), those without a picture and the marks that turn the
    direction of writing become �; line breaks and tabs stay.

    Example:
        >>> visible("joint\\x1b[2J")
        'joint␛[2J'
    """
    return text.translate(HIDDEN)


class RankdropError(Exception):
    """Base of every error that rankdrop raises on purpose.

    The parts are kept as attributes, so that a program can read them; `str(error)` is one line.

    Args:
        what: what is wrong, as a claim ("lower limit is above the upper limit").
        where: file, line, element or joint.
        got: the value met.
        allowed: what would have been accepted.
        mend: what to do about it, in the words of Python.
        typed: the same mend in the words of the command line ("--tip tool0"), where they differ.
    """

    def __init__(
        self,
        what: str,
        *,
        where: str | None = None,
        got: Any = None,
        allowed: Any = None,
        mend: str | None = None,
        typed: str | None = None,
    ) -> None:
        self.what, self.where, self.got, self.allowed, self.mend, self.typed = what, where, got, allowed, mend, typed
        super().__init__(self._line(mend, where))

    @property
    def parts(self) -> dict[str, Any]:
        """What the error was made of, by name: to make another one of it."""
        return {name: getattr(self, name) for name in ("what", "where", "got", "allowed", "mend", "typed")}

    def on_command_line(self, options: Container[str] = ()) -> str:
        """The one line as a command shows it: with the names of its options, not the Python keywords."""
        option = f"--{self.where}".replace("_", "-")
        return self._line(self.mend if self.typed is None else self.typed, option if option in options else self.where)

    def _line(self, mend: str | None, where: str | None) -> str:
        parts = [f"{_error_part(where)}: {_error_part(self.what)}" if where else _error_part(self.what)]
        if self.got is not None:
            parts.append(f"got {_error_part(self.got, _LONGEST_ECHO)}")
        if self.allowed is not None:
            parts.append(f"allowed: {_error_part(self.allowed)}")
        if mend:
            parts.append(f"fix: {_error_part(mend)}")
        return " ".join("; ".join(parts).split())


def _error_part(part: Any, longest: int = _LONGEST_PART) -> str:
    """A part of an error: nothing that steers a terminal, and both ends of what is too long."""
    text = visible(str(part))
    if len(text) <= longest:
        return text
    return f"{text[: longest // 2]} … {text[-longest // 2 :]}"


class RobotError(RankdropError):
    """A robot description (file, table, screw set) that cannot be used as it stands."""


class UnknownRobotError(RobotError):
    """A name that is neither in the catalogue nor a file."""


class ConfigurationError(RankdropError):
    """A configuration q (or a batch of them) of the wrong shape or with values that are not finite."""


class TaskError(RankdropError):
    """A task, frame or length scale that does not exist or makes no sense for the arm."""


class OptionError(RankdropError):
    """An option (method, corank, number of starts …) outside what is allowed."""


class ResultFileError(RankdropError):
    """A result that cannot be saved, or not be read back."""


class MissingExtraError(RankdropError):
    """A package is not installed; says how the source of rankdrop installs it.

    Args:
        package: that is missing.
        extra: of rankdrop that brings it; None for what the plain install brings.
        purpose: what needs it.
    """

    def __init__(self, package: str, extra: str | None, purpose: str) -> None:
        self.package, self.extra = package, extra
        if extra is None:
            source = "."
        else:
            source = f'".[{extra}]"'
        super().__init__(f"{purpose} needs the package {package}",
                         mend=f"in the folder of rankdrop's source: pip install {source}")  # fmt: skip
