"""A robot by its name in the catalogue or by its file; with a note where its numbers are of an unlikely size."""

from __future__ import annotations

import difflib
import re
import tomllib
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from os import PathLike
from pathlib import Path

from rankdrop.errors import RobotError, UnknownRobotError
from rankdrop.robot.arm_reach import link_lengths
from rankdrop.robot.files import read_text
from rankdrop.robot.formats import BLANK, RobotFile, format_endings, format_names, format_of
from rankdrop.robot.model import Robot
from rankdrop.robot.note import NoteOn, RobotNote
from rankdrop.robot.toml_file import robot_from_toml

_SEVERAL = {"cylindrical": 2, "spherical": 3}  # variables of the joints of a screw file that are not one
_SUGGESTED, _TELLING = 3, 2  # names that an error suggests; letters of a text from which it is looked for inside names

_DIGITS = re.compile(r"\d+")
_LARGEST = 30.0  # [m]; Canadarm2, the longest arm flown, reaches 17.6 m, and arms of 30 mm become 30 m
_SMALLEST = 0.03  # [m]; the smallest arms sold reach some 0.2 m
_NOTHING = 1e-9  # [m]; a bare wrist has no length at all, and none is missing


@dataclass(frozen=True, slots=True)
class CatalogEntry:
    """One arm of the catalogue.

    Attributes:
        name: that `open_robot` takes.
        maker: "" for arms of documents and textbooks.
        about: one line.
        n: number of variables.
        task: that it is made for.
        source: where its numbers are from.
        aliases: other names that `open_robot` takes.
    """

    name: str
    maker: str
    about: str
    n: int
    task: str
    source: str
    aliases: tuple[str, ...]


def open_robot(
    name_or_path: str | PathLike[str],
    *,
    tip: str | None = None,
    base: str | None = None,
    packages: Mapping[str, str | PathLike[str]] | None = None,
    args: Mapping[str, object] | None = None,
    xacro: bool = False,
    as_written: bool = False,
) -> Robot:
    """A robot from its name in the catalogue, or from a file: DH or screw TOML, URDF, xacro, MJCF, or plain screws, six
    numbers a line.

    A catalogue name wins over a file of the same name; write "./pa10" for the file. Capitals, blanks, - and _ make no
    difference to a name ("UR 5e"), but a file that is called exactly so comes first. The maker may be in front, and
    what `rankdrop robots` prints is a name too: "KUKA LBR iiwa 14 R820".

    Numbers that are rounded decimals of multiples of 15°, and structure that holds to 2e-5 rad and 2 µm (axes parallel,
    at right angles, meeting), are taken as exact; a note of the robot says how many and by how much.

    Expanding a xacro file can run any command, as xacro itself can: it is done for files that end in .xacro, or where
    `xacro` is true, and never for what a file holds.

    Args:
        name_or_path: "pa10", or a path.
        tip, base: names of links (MJCF: of bodies or sites); by default they are chosen, and `Robot.notes` says how.
        packages: package name -> folder, for xacro files with $(find …); others are looked for near the file.
        args: values of the arguments of a xacro file, `<xacro:arg>`.
        xacro: expand the file whatever its ending.
        as_written: keep the numbers of the file as they are.

    Raises:
        UnknownRobotError: neither a name of the catalogue nor a file; suggests names that are close.
        RobotError: the file cannot be read or used, or takes no arguments.
        MissingExtraError: an MJCF file without the extra "mujoco".

    Example:
        >>> open_robot("pa10").n
        7
    """
    path = _resolve(name_or_path)
    if isinstance(path, str):
        _refuse_arguments(path, args)
        _refuse_links(path, tip, base)
        return _from_catalog(path)
    text = read_text(path)
    if not text.strip(BLANK):
        raise RobotError("the file is empty", where=str(path), allowed=format_names())
    file = RobotFile(path, text, base, tip, as_written, packages or {}, args or {}, xacro)
    form = format_of(file)
    if not form.links:
        _refuse_links(str(path), tip, base)
    robot = form.read(file)
    if not form.arguments:
        _refuse_arguments(str(path), args)  # last: the file may be xacro under another name, an error of its own
    return with_size_note(robot)


def _resolve(name_or_path: str | PathLike[str]) -> str | Path:
    """The name in the catalogue, or the path of a file that is there."""
    name = str(name_or_path)
    if isinstance(name_or_path, str) and name in _catalog_files():
        return name
    if name and _exists(Path(name)):
        return Path(name)
    if isinstance(name_or_path, str):
        same = _same_names(name)
    else:
        same = []
    if len(same) != 1:
        raise _unknown(name)
    return same[0]


def names_an_arm(name: str) -> bool:
    """Whether `open_robot` would find a name: in the catalogue, or as a file, which is not opened."""
    try:
        _resolve(name)
    except UnknownRobotError:
        return False
    return True


def source_text(name_or_path: str) -> tuple[str, str] | None:
    """The text that a robot is described by, and the file it is from; None for xacro files, which are no description.

    Args:
        name_or_path: as for `open_robot`.

    Raises:
        UnknownRobotError, RobotError: as `open_robot`.
    """
    source = _resolve(name_or_path)
    if isinstance(source, str):
        return _catalog_files()[source].read_text(encoding="utf-8"), f"catalogue {source}.toml"
    if source.suffix.lower() == ".xacro":
        return None
    return (read_text(source), name_or_path)


def robot_names() -> tuple[str, ...]:
    """The names of the catalogue, sorted."""
    return tuple(sorted(_catalog_files()))


def catalog_entries() -> tuple[CatalogEntry, ...]:
    """What the catalogue holds, by name."""
    return tuple(_entry(name) for name in robot_names())


def search_catalog(text: str) -> tuple[CatalogEntry, ...]:
    """The arms whose name, other names, maker or description hold every word of a text, in any spelling.

    Example:
        >>> [entry.name for entry in search_catalog("kuka iiwa")]
        ['iiwa14', 'iiwa7']
    """
    words = [_plain(word) for word in text.split()]

    def fits(entry: CatalogEntry) -> bool:
        told = _plain(" ".join((entry.name, *entry.aliases, entry.maker, entry.about)))
        return all(word in told for word in words)

    return tuple(entry for entry in catalog_entries() if fits(entry))


@cache
def _entry(name: str) -> CatalogEntry:
    document = tomllib.loads(_catalog_files()[name].read_text(encoding="utf-8"))
    n = sum(_SEVERAL.get(joint.get("kind", ""), 1) for joint in document["joints"])
    texts = {key: str(document.get(key, "")) for key in ("maker", "about", "source")}
    task, aliases = document.get("task", "pose"), tuple(document.get("aliases", ()))
    return CatalogEntry(name, texts["maker"], texts["about"], n, task, texts["source"], aliases)


@cache
def _catalog_files() -> dict[str, Traversable]:
    folder = resources.files("rankdrop.robot") / "catalog"
    return {item.name.removesuffix(".toml"): item for item in folder.iterdir() if item.name.endswith(".toml")}


@cache
def _from_catalog(name: str) -> Robot:
    text = _catalog_files()[name].read_text(encoding="utf-8")
    return robot_from_toml(text, file=f"catalogue {name}.toml", default_name=name, kind="catalogue")


def _refuse_links(name: str, tip: str | None, base: str | None) -> None:
    for label, link in (("tip", tip), ("base", base)):
        if link is not None:
            raise RobotError(
                f"this robot has no links to name as its {label}", where=name, got=repr(link),
                allowed=f"{label} with a URDF or xacro file",
            )


def _refuse_arguments(name: str, args: Mapping[str, object] | None) -> None:
    if args:
        raise RobotError("only a xacro file has arguments", where=name, got=", ".join(args),
                         mend="leave args out", typed="leave --arg out")  # fmt: skip


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # a name too long for the file system, or with a zero byte
        return False


def _plain(name: str) -> str:
    """A name without what people write differently: capitals, accents, blanks, - and _."""
    letters = unicodedata.normalize("NFKD", name)
    kept = (sign for sign in letters if not (sign in "-_" or sign.isspace() or unicodedata.combining(sign)))
    return "".join(kept).lower()


def _same_names(name: str) -> list[str]:
    plain = _plain(name)
    by_name = [known for known in robot_names() if _plain(known) == plain]
    return by_name or list(_spellings().get(plain, ()))


@cache
def _spellings() -> dict[str, list[str]]:
    """Ways to write an arm, as `_plain` has them -> names: as `rankdrop robots` prints it, with or without maker."""
    spellings: dict[str, list[str]] = {}
    for entry in catalog_entries():
        for spelling in {_plain(text) for text in _titles(entry)}:
            spellings.setdefault(spelling, []).append(entry.name)
    return spellings


def _titles(entry: CatalogEntry) -> Iterator[str]:
    """Texts that name one arm: "irb120_3_58", "ABB irb120", "ABB IRB 120-3/0.58, 6R, …", "IRB 120-3/0.58"."""
    title = entry.about.partition(",")[0]
    for text in (entry.about, title, *entry.aliases):
        yield text
        yield text.removeprefix(entry.maker)
        yield entry.maker + text
    yield entry.maker + entry.name


def _close_names(name: str) -> list[str]:
    alike = difflib.get_close_matches(name.lower()[:80], robot_names(), n=3, cutoff=0.5)
    return _same_names(name) or _listed_names(name) or alike


def _listed_names(name: str) -> list[str]:
    """The few arms that hold every word of a name."""
    names = [entry.name for entry in search_catalog(name[:80])]
    if len(_plain(name)) < _TELLING or len(names) > _SUGGESTED:
        return []
    return names


def _unknown(name: str) -> UnknownRobotError:
    if len(name) <= 500:
        shown = name
    else:
        shown = name[:499] + "…"
    if "/" in name or "\\" in name or name.lower().endswith((*format_endings(), ".sdf")):
        return _no_file(name, shown)
    close = _close_names(name)
    mend = _meant([known for known in close if _may_be_meant(name, known)])
    fitting = 0
    if len(_plain(name)) >= _TELLING:
        fitting = len(search_catalog(name[:80]))
    if fitting > _SUGGESTED:
        mend = f"{fitting} arms fit: rankdrop robots {name[:80]!r} lists them"
    allowed = f"a file, or one of {len(robot_names())} names: rankdrop robots lists them"
    what = "there is no such robot in the catalogue and no such file"
    if mend is None and close:
        return _only_others(shown, close)
    return UnknownRobotError(what, got=repr(shown), allowed=allowed, mend=mend)


def _no_file(name: str, shown: str) -> UnknownRobotError:
    mend = _meant(_same_names(Path(name).stem))  # ur5e.urdf: the catalogue has ur5e
    before = re.split(r"[/\\]", name, maxsplit=1)[0]  # "LR Mate 200iD/7L": the catalogue has lrmate200id
    others = _same_names(before) or _listed_names(before)
    if mend is None and others:
        return _only_others(shown, others)
    return UnknownRobotError("there is no such file", got=repr(shown), allowed=None, mend=mend)


def _only_others(shown: str, names: Sequence[str]) -> UnknownRobotError:
    """Names that are alike, of arms that are others."""
    return UnknownRobotError("there is no such robot in the catalogue and no such file", got=repr(shown),
                             allowed=f"a file, or one of {len(robot_names())} names: rankdrop robots lists them",
                             mend=f"give a file; the catalogue has other arms: {', '.join(names)}")  # fmt: skip


def _may_be_meant(name: str, known: str) -> bool:
    """Whether a name may be a slip for this arm, or a part of its name; with other numbers it is another arm."""
    plain = _plain(name)
    if known in _listed_names(name) or known.startswith(plain):
        return True
    return _DIGITS.findall(plain) == _DIGITS.findall(known) and not plain.startswith(_plain(known))


def _meant(names: Sequence[str]) -> str | None:
    """The question whether one of these names was meant; None where there are none."""
    if not names:
        return None
    return f"did you mean {' or '.join(names)}?"


def with_size_note(robot: Robot) -> Robot:
    """The same robot, with a note where its reach (see `rankdrop.robot.numbers`) is above 30 m or below 3 cm."""
    length = float(link_lengths(robot).sum())
    if not (length > _LARGEST or _NOTHING < length < _SMALLEST):
        return robot
    return replace(robot, notes=(*robot.notes, RobotNote(NoteOn.SIZE, value=length)))
