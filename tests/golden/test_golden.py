"""What the commands print, word for word.

After a change that is meant, write the files again and read the difference:

    RANKDROP_GOLDEN=write pytest -m "slow or not slow" tests/golden && git diff tests/golden README.md
"""

from __future__ import annotations

import os
import shlex
from pathlib import Path

import pytest
from golden.noise import without_noise, without_time

from rankdrop.cli import main

HERE = Path(__file__).parent
README = HERE.parents[1] / "README.md"
WRITE = os.environ.get("RANKDROP_GOLDEN") == "write"

TABLES = {
    "pa10-80.txt": (80, "analyze pa10 --starts 500 --quiet"),
    "pa10-140.txt": (140, "analyze pa10 --starts 500 --quiet --full"),
    "puma560-100.txt": (100, "analyze puma560 --starts 500 --quiet --full"),
    "scara-pose-80.txt": (80, "analyze scara --task pose --starts 500 --quiet"),
}

EXPLANATIONS = {
    "explain-80.txt": (80, "explain puma560 --deg --q 10,20,30,40,0,50"),
    "escape-100.txt": (100, "escape rcrrrr --q 0,0,0,0,0,0,0 --length-scale 1"),
    "nearest-60.txt": (60, "nearest ur5 --deg --q 0,-135,45,90,-90,0 --evaluations 0"),
}

CONDITIONS = {
    "conditions-80.txt": (80, "conditions pa10 --quiet"),
    "steps-100.txt": (
        100, "conditions canadarm2 --steps --coranks 1 --points 200 --lengths a=0.635,c=0.504,d=6.85 --quiet",
    ),
    "ideal-100.txt": (100, "conditions gen3 --ideal 13mm --quiet --full"),
    "ideal-explain-80.txt": (80, "explain gen3_6dof --ideal 1.1mm --q 0.1,0.5,1,0.3,0.01,0.2"),
    "test-80.txt": (80, "conditions puma560 --quiet --test 'sin(q5)*(a3*sin(q3)+d4*cos(q3))'"),
}  # fmt: skip

# errors in our own words; those about options are in the words of the parser
ERRORS = [
    "analyze nowhere.urdf",
    "analyze pa10 --task flying",
    "analyze pa10 --starts 0",
    "analyze pa10 --json /no/such/folder/pa10.json",
    "analyze pa10 --package arm",
    "conditions puma560 --test 'sin(q5)*foo(q3)'",
    "conditions pa10 --lengths a=0.4",
    "find pa10 --corank 9",
    "find pa10 --corank 1 --out found.xls",
    "analyze pa10 --arg side:=left",
    "analyze pa10 --arg side=left",
    "analyze files/two_arms.urdf",
    "analyze files/generated.urdf",
    "analyze files/arm.sdf",
    "conditions files/needs.urdf.xacro",
    "conditions files/model.urdf.xacro",
    "conditions files/model.urdf.xacro --arg model:=x --arg sde:=right",
]


def compare(name: str, text: str) -> None:
    """Compare with the file, or write it."""
    path = HERE / name
    if WRITE:
        path.write_text(text, encoding="utf-8")
    assert text == path.read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("name", TABLES | CONDITIONS)
def test_tables_and_conditions_are_as_they_were(
    name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    width, line = (TABLES | CONDITIONS)[name]
    monkeypatch.setenv("COLUMNS", str(width))
    code = main.run(shlex.split(line))
    text = without_time(capsys.readouterr().out)
    compare(name, f"$ COLUMNS={width} rankdrop {line}\n{text}exit code {code}\n")


@pytest.mark.parametrize("name", EXPLANATIONS)
def test_explanations_are_as_they_were(
    name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    width, line = EXPLANATIONS[name]
    monkeypatch.setenv("COLUMNS", str(width))
    code = main.run(shlex.split(line))
    text = f"$ COLUMNS={width} rankdrop {line}\n{capsys.readouterr().out}exit code {code}\n"
    if WRITE:
        (HERE / name).write_text(text, encoding="utf-8")
    assert without_noise(text) == without_noise((HERE / name).read_text(encoding="utf-8"))


README_BLOCKS = {
    3: ("analyze ur5e", 100, lambda text: "\n".join([*text.splitlines()[:11], "…\n"])),
    4: ("explain ur5e --deg --q 0,-60,0,40,50,0", 80, lambda text: "\n".join([*text.splitlines()[:7], "…\n"])),
    5: ("path ur5e --example pick.csv; path ur5e pick.csv", 80,
        lambda text: "\n".join([*text.splitlines()[:6], "…\n"])),
}
"""Place of the console block in the README: command lines, width, the part of the output that it shows."""


@pytest.mark.slow
@pytest.mark.shipped  # as it is installed
@pytest.mark.parametrize("place", README_BLOCKS)
def test_the_readme_shows_what_is_printed(
    place: int, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a newcomer sees it, from an empty folder."""
    lines, width, part = README_BLOCKS[place]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", str(width))
    for line in lines.split("; "):
        assert main.run([*shlex.split(line), "--quiet"]) in (0, 3, 4)
    typed = "".join(f"$ rankdrop {line}\n" for line in lines.split("; "))
    readme_block(place, typed + part(capsys.readouterr().out))


def readme_block(place: int, wanted: str) -> None:
    """The README's console block of this place (from 1) is what is wanted, but for times; written where asked for."""
    text = README.read_text(encoding="utf-8")
    blocks = text.split("```console\n")
    shown, rest = blocks[place].split("```\n", 1)
    if WRITE:
        blocks[place] = f"{wanted}```\n{rest}"
        README.write_text("```console\n".join(blocks), encoding="utf-8")
        shown = wanted
    assert without_noise(without_time(shown)) == without_noise(without_time(wanted))


@pytest.mark.slow
def test_errors_are_as_they_were(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("xacro")
    monkeypatch.chdir(HERE)
    text = ""
    for line in ERRORS:
        code = main.run(shlex.split(line))
        text += f"$ rankdrop {line}\n{capsys.readouterr().err}exit code {code}\n\n"
    compare("errors.txt", text)
