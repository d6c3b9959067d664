"""Which configuration, pose or numbers does a text on the command line write?

Quantities may carry units (deg, mm …) and be arithmetic with pi and sqrt; without a unit they are in rad and m, or with
--deg in degrees.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import accumulate
from math import degrees, pi, radians
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from rankdrop import robot as arms
from rankdrop.cli.terminal import say
from rankdrop.errors import ConfigurationError, OptionError, RobotError

if TYPE_CHECKING:
    from rankdrop.cover import ModelTolerance

_WHOLE_TO = 1e-9  # of a typed angle [deg]
_SEPARATOR = re.compile(r"\s*[,;]\s*|\s+")
_SIGNS = str.maketrans({"−": "-", "–": "-", "π": "pi"})  # as copied from what is printed
_AS_TYPED = _SIGNS | str.maketrans("{}", "  ")

Q = Annotated[str, Parameter(
    help="One number per joint, separated by commas or blanks [rad, m]; pi/2, 30deg, 120mm are understood.",
    allow_leading_hyphen=True,
)]  # fmt: skip

POSE = Annotated[str, Parameter(
    help="Pose of the tip in the base axes: x,y,z,roll,pitch,yaw or x,y,z,qx,qy,qz,qw, for a position x,y,z "
    "[m, rad]; 30deg, 120mm are understood. Also as makers write it: p[x,y,z,rx,ry,rz], {X 100, …, A 0, B 90, C 0}, "
    "X 100 … W 180 P 0 R 0, a robtarget of RAPID, posx(…) of DRL; x,y,z,qw,qx,qy,qz wxyz; a matrix [[…], …], "
    "or a pose message of ROS.",
    allow_leading_hyphen=True,
)]  # fmt: skip


def model_tolerance(text: str | None) -> ModelTolerance | None:
    """A tolerance as it is typed: 0.3mm,1mrad; one of the two alone leaves the other at zero.

    Raises:
        OptionError: not a length, an angle or both; or an angle too large.
    """
    if text is None:
        return None
    from rankdrop.cover import ModelTolerance

    given = arms.read_tolerance(text, where="--model-tolerance")
    return ModelTolerance(given.length or 0.0, given.angle or 0.0)


def parse_configuration(text: str, robot: arms.Robot, *, deg: bool, option: str = "--q") -> list[float]:
    """The joint values that a text writes, one per joint, in rad and m.

    Numbers are separated by commas, semicolons or blanks; each is arithmetic with pi and sqrt, and may carry a unit
    (deg, rad, m, mm …). A number without a unit is in rad, or in degrees with `deg`; slides are in m. The signs − and
    π are understood: what was printed can be pasted, and so can a list with what code, a message of ROS or a program
    has around it (`robot.joint_text`), {A1 0, A2 −90, …} by names or by letters and number.

    Raises:
        ConfigurationError: not one number for each joint, or a word that is no number.
    """
    joints = robot.variables
    names = [joint.name for joint in joints]
    pasted = arms.joints_of_text(text.translate(_SIGNS), names, where=option)
    words = list(pasted.words) or _values_by_name(pasted.text, names, option) or split_values(pasted.text)
    if len(words) != len(joints):
        raise ConfigurationError(
            f"{len(joints)} joint values are needed", where=option, got=f"{len(words)} in {text!r}",
            allowed=joint_units(robot, deg=deg),
            mend=_decimal_comma_fix(text, len(joints)) or f'write them as {option}="0,0.5,…"',
        )  # fmt: skip
    if pasted.degrees and not deg:
        say(f"note: {option}: angles of this form are in degrees")
    _note_on_level_joint(text, robot, option)
    values = [
        value_of(word, joint.unit, f"{option}, joint {joint.name}", deg=deg or pasted.degrees)
        for word, joint in zip(words, joints, strict=True)
    ]
    typed = [degrees(abs(x)) for x, joint in zip(values, joints, strict=True) if joint.unit == "rad"]
    if deg and 0.0 < max(typed, default=0.0) <= pi and any(x % 1.0 > _WHOLE_TO for x in typed):
        say(f"note: angles up to {max(typed):.4g} look like radians and are read as degrees")
    return values


def _note_on_level_joint(text: str, robot: arms.Robot, option: str) -> None:
    """Values as FANUC's pendant lists them, J1= 0.000 deg, …: its J3 is another angle than joint 3."""
    if not re.search(r"\bJ3\s*=", text):
        return
    from rankdrop.path import axes_2_and_3_opposed

    if axes_2_and_3_opposed(robot):
        say(f"note: {option}: J3 is read as joint 3; a FANUC counts J3 from the horizontal: then write J3 + J2")


def _values_by_name(text: str, names: Sequence[str], option: str) -> list[str]:
    """The values of a list such as {A1 0, A2 -90} or "j1=0 j2=1.5", one for each joint; empty for any other list.

    Raises:
        ConfigurationError: every value has a name with = or :, and these are not the joints in their order.
    """
    items = _items_with_names(text.translate(_AS_TYPED).strip().strip("{}[]()").strip().rstrip(",;"))
    if len(items) != len(names):
        return []
    values = []
    for number, (item, name) in enumerate(zip(items, names, strict=True), start=1):
        found = re.fullmatch(r"([A-Za-z]\w*)\s*[\s:=]\s*(.+)", item.strip())
        if found is None or not (found[1] == name or re.fullmatch(rf"\w*[A-Za-z_]{number}", found[1])):
            _refuse_other_names(items, names, option)
            return []
        values.append(found[2].strip())
    return values


def _refuse_other_names(items: Sequence[str], names: Sequence[str], option: str) -> None:
    given = [re.match(r"\s*([A-Za-z]\w*)\s*[=:]", item) for item in items]
    if all(given):
        raise ConfigurationError("the names are not those of the joints in their order", where=option,
                                 got=", ".join(found[1] for found in given if found), allowed=", ".join(names),
                                 mend="write the values alone, in this order")  # fmt: skip


def _items_with_names(text: str) -> list[str]:
    """The parts of a list at its commas, or, where it has none, in front of its names: "J1=0", "J2=-90 deg"."""
    if re.search(r"[,;]", text):
        return re.split(r"[,;]", text)
    return re.split(r"(?<!\s)\s+(?=[A-Za-z]\w{0,60}\s{0,10}[=:])", text)


def joint_units(robot: arms.Robot, *, deg: bool) -> str:
    """The joints with the units their values are read in: "elbow [deg], lift [m]"."""
    units = {"rad": "deg" if deg else "rad"}
    return ", ".join(f"{joint.name} [{units.get(joint.unit, joint.unit)}]" for joint in robot.variables)


def _decimal_comma_fix(text: str, count: int) -> str | None:
    """The fix of a list with decimal commas, 0,5; 1,2 …; None for any other list."""
    words = re.split(r"\s*;\s*|\s+", text.strip())
    commas = all(re.fullmatch(r"[-+−]?\d+(,\d+)?\D*", word) for word in words)
    fits = commas and len(words) == count
    if fits:
        return f"write decimals with points: {'; '.join(words).replace(',', '.')}"
    return None


def split_values(text: str) -> list[str]:
    """The words of a list of quantities, however it is bracketed and separated."""
    body = _without_brackets(text.translate(_AS_TYPED).strip()).strip().rstrip(",;")
    if body:
        return _SEPARATOR.split(body)
    return []


def _without_brackets(text: str) -> str:
    """[…] and (…) around the whole list, not those of the first and the last number."""
    if text[:1] == "[" and text[-1:] == "]":
        return text[1:-1]
    *depths, end = accumulate((letter == "(") - (letter == ")") for letter in text or " ")
    around = text[:1] == "(" and text[-1:] == ")" and end == 0 and all(depth > 0 for depth in depths)
    return text[1:-1] if around else text


def value_of(word: str, unit: str, where: str, *, deg: bool) -> float:
    """One quantity in rad or m; an angle without a unit is in degrees with `deg`.

    Raises:
        ConfigurationError: it is none.
    """
    try:
        value = arms.quantity(word, "length" if unit == "m" else "angle", where=where)
    except RobotError as error:
        raise ConfigurationError(**error.parts) from error
    plain = not re.search(r"(deg|rad|°)$", word)
    if deg and unit == "rad" and plain:
        return radians(value)
    return value


def parse_pose(text: str, *, deg: bool, option: str = "--pose", robot: arms.Robot | None = None) -> list[float]:
    """The numbers of a pose: three lengths, then none, three angles or four of a quaternion, in m and rad.

    A pose in a maker's form is read by its conventions (`path.read.pose_text`), and a note says so; the arm says where
    FANUC's Z begins.

    Raises:
        OptionError: not three, six or seven quantities, a maker's form in doubt, or angles that look like degrees.
        ConfigurationError: a word that is none.
    """
    from rankdrop.path import refuse_bare_degrees, target_of_text

    made = _makers_pose(text, option, robot, deg=deg)
    if made is not None:
        return made
    words = split_values(target_of_text(text))
    if len(words) not in (3, 6, 7):
        raise OptionError("a pose is three lengths, then three angles or a quaternion", where=option,
                          got=f"{len(words)} numbers in {text!r}",
                          allowed="x,y,z,roll,pitch,yaw or x,y,z,qx,qy,qz,qw; for a position x,y,z [m, rad]",
                          mend=f'write it as {option}="0.3,0,0.4,180deg,0,0"')  # fmt: skip
    lengths = [value_of(word, "m", option, deg=deg) for word in words[:3]]
    if len(words) == 7:
        return lengths + [arms.quantity(word, "number", where=option) for word in words[3:]]
    turns = [value_of(word, "rad", option, deg=deg) for word in words[3:]]
    if not deg:
        refuse_bare_degrees(words[3:], turns, option)
    return lengths + turns


def _makers_pose(text: str, option: str, robot: arms.Robot | None, *, deg: bool) -> list[float] | None:
    """The numbers of a pose in a maker's form, with notes on how it is read; None for a plain list of numbers."""
    from rankdrop.path import pose_of_text

    made = pose_of_text(text, option, deg=deg, robot=robot)
    if made is None:
        return None
    for note in made.notes:
        say(f"note: {option}: {note}")
    return made.numbers


def numbers_of(text: str, option: str) -> list[float]:
    """Numbers separated by commas or blanks.

    Raises:
        OptionError: a word is no number.
    """
    try:
        return [float(word) for word in text.replace("−", "-").replace(",", " ").split()]
    except ValueError as error:
        raise OptionError("these are not numbers", where=option, got=repr(text), allowed="1,0,0,…") from error
