"""Without --full an output has at most 40 lines of 80 columns, and its first line is the answer; no table is clipped.

Analyses and conditions are those that are shipped, printed by the blocks that the commands print.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from functools import partial

import pytest
from rich.cells import cell_len

import rankdrop
from rankdrop.cli import analyze as analyzing
from rankdrop.cli import exits, main
from rankdrop.cli.terminal import BRIEF, fit_to_console, print_blocks
from rankdrop.families.record import Check
from rankdrop.families.summary import Evidence, FamilySummary, RankSummary
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import known_names, shipped
from rankdrop.sections import Section
from rankdrop.text import opening

WIDTH = 80
DOZEN = ("ur5e", "yumi", "pa10", "iiwa7", "crx10ia", "panda", "gp7", "fetch", "z1", "yam", "canadarm2", "scara")
CLIPPED = re.compile(r"…\s*$|\S…(\s{2,}|$)")


@pytest.fixture(autouse=True)
def eighty(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(WIDTH))


def printed(capsys: pytest.CaptureFixture[str], *words: str) -> list[str]:
    """Lines of a command, which ends as it does for what it is asked."""
    capsys.readouterr()
    assert main.run([*words, "--quiet"] if words[0] != "nearest" else [*words]) in (exits.FINE, exits.UNEXPLAINED)
    return capsys.readouterr().out.splitlines()


def lines_of(blocks: Iterable[object], capsys: pytest.CaptureFixture[str]) -> list[str]:
    capsys.readouterr()
    print_blocks(blocks)  # type: ignore[arg-type]
    return capsys.readouterr().out.splitlines()


def check(lines: list[str], begins: str, most: int = BRIEF) -> None:
    assert len(lines) <= most
    assert max(map(cell_len, lines)) <= WIDTH
    assert " ".join(lines[:2]).strip().startswith(begins)
    assert not [line for line in lines if CLIPPED.search(line)]


def brief(found: Analysis, capsys: pytest.CaptureFixture[str]) -> list[str]:
    return lines_of(analyzing._brief(found, found.task, None, None, seconds=1.0), capsys)


def whole(found: Analysis, capsys: pytest.CaptureFixture[str]) -> list[str]:
    return lines_of(analyzing._blocks(found, found.task, None, ((), ()), None, seconds=1.0, every=True), capsys)


def begins(found: Analysis) -> str:
    count = len(found.families)
    return f"{found.robot.name} has {count} famil{'y' if count == 1 else 'ies'} of singularities: "


@pytest.mark.slow_at("yumi")
@pytest.mark.shipped
@pytest.mark.parametrize("name", DOZEN)
def test_analyze_has_at_most_forty_lines_and_begins_with_the_answer(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    found = shipped(name)
    lines = brief(found, capsys)
    check(lines, "Arm as written (--ideal" if lines[0].startswith("Arm as written") else begins(found))
    text = " ".join(" ".join(lines).split())
    assert begins(found) in text
    for ranked in found.summary.ranks:
        assert f"(rank {ranked.rank})" in text
    assert "Verified by" in text


@pytest.mark.shipped
@pytest.mark.by_hand
@pytest.mark.parametrize("name", known_names())
def test_every_arm_of_the_catalogue_has_at_most_forty_lines_and_whole_tables(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    found = shipped(name)
    test_analyze_has_at_most_forty_lines_and_begins_with_the_answer(name, capsys)
    check(whole(found, capsys), "", most=1000)


def ranked(rank: int, families: int, combinations: int, **names: int) -> RankSummary:
    return RankSummary(rank, 6 - rank, families, combinations, names)


@pytest.mark.parametrize(
    ("ranks", "said"),
    [
        ((), "arm: no family of singularities was found."),
        ((ranked(5, 1, 0, wrist=1),), "arm has 1 family of singularities: wrist (rank 5)."),
        ((ranked(5, 3, 0, wrist=2, elbow=1), ranked(4, 1, 1)),
         "arm has 4 families of singularities: wrist (2 families), elbow (rank 5); 1 combination (rank 4)."),
        ((ranked(5, 1, 0, wrist=1), ranked(4, 4, 1), ranked(3, 2, 2)),
         "arm has 7 families of singularities: wrist (rank 5); 1 combination and 3 more (rank 4); 2 combinations "
         "(rank 3)."),
        ((ranked(5, 1, 0, wrist=1), ranked(4, 4, 0), ranked(3, 1, 0)),
         "arm has 6 families of singularities: wrist (rank 5); 4 more (rank 4); 1 (rank 3)."),
        ((ranked(5, 9, 0, a=1, b=1, c=1, d=1, e=1, f=2, g=2),),
         "arm has 9 families of singularities: a, b, c, d, e, f (2 families), 2 more (rank 5)."),
    ],
)  # fmt: skip
def test_families_are_counted_by_rank(ranks: tuple[RankSummary, ...], said: str) -> None:
    assert opening(FamilySummary("arm", 6, ranks, Evidence.TESTED, 10)) == said


def test_a_failed_test_is_shown_in_the_row_of_its_family(capsys: pytest.CaptureFixture[str]) -> None:
    found = shipped("planar3r")
    family = replace(found.families[0], soundness=Check(10, 9))
    lines = brief(replace(found, families=(family,)), capsys)
    assert lines[0].startswith("A test failed: ")
    assert any("TESTED 90 %" in line for line in lines)


def test_optional_sections_go_first_then_rows_from_the_end(capsys: pytest.CaptureFixture[str]) -> None:
    head, extra = Section("Answer"), Section("Extra", lines=("one", "two"))
    table = Section("", columns=("a",), rows=tuple((str(i),) for i in range(30)))
    shown = partial(lines_of, capsys=capsys)
    fits = shown(fit_to_console([head, table, extra], optional=[extra], cut=[table]))
    assert "Extra" in fits
    long = replace(table, rows=table.rows * 3)
    fits = shown(fit_to_console([head, long, extra], optional=[extra], cut=[long]))
    assert (len(fits), "Extra" in fits, fits[0], fits[-1]) == (BRIEF, False, "Answer", "  and 55 more: --full")


COMMANDS = {
    "conditions ur5e": "ur5e has 9 families of singularities: shoulder, elbow, wrist (rank 5)",
    "conditions yumi": "yumi has 28 families of singularities",
    "jacobian yumi": "yumi: Jacobian in the frame of link",
    "jacobian ur5e --inverse --frame 4": "ur5e: Jacobian in the frame of link 4",
    "nearest ur5e --deg --q 0,-135,45,90,-90,0 --evaluations 100": "ur5e is regular",
    "tolerant planar3r": "No configuration of planar3r tolerates every single joint failure",
    "find planar3r --corank 1 --starts 100": "planar3r has singular configurations of corank 1 (rank 2 of 3)",
    "cover planar3r": "Every singular configuration of planar3r is within",
}


@pytest.mark.by_hand_at("jacobian ur5e --inverse --frame 4", "jacobian yumi")
@pytest.mark.shipped
@pytest.mark.slow_at("jacobian yumi", "jacobian ur5e --inverse --frame 4", "cover planar3r", "conditions yumi")
@pytest.mark.parametrize("line", COMMANDS)
def test_a_command_prints_at_most_forty_lines_and_begins_with_the_answer(
    line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    check(printed(capsys, *line.split()), COMMANDS[line])


@pytest.mark.by_hand
@pytest.mark.shipped
def test_compare_says_which_arm_is_best_and_lists_families_with_full_only(
    capsys: pytest.CaptureFixture[str],
) -> None:
    line = ("compare", "ur5e", "gp7", "--starts", "100")
    lines = printed(capsys, *line)
    check(lines, "ur5e and gp7 do not differ within the error, for task pose.")
    assert "  gp7: shoulder, elbow, wrist (corank 1); 6 (corank 2)" in lines
    assert "gp7  Yaskawa Motoman GP7, 6R, spherical wrist" in printed(capsys, *line, "--full")


@pytest.mark.shipped
@pytest.mark.by_hand
@pytest.mark.parametrize("name", known_names())
def test_conditions_jacobian_and_nearest_of_every_arm_have_at_most_forty_lines(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = rankdrop.open_robot(name)
    q = ",".join("0.3" if joint.unit == "rad" else "0.01" for joint in robot.variables)
    for line in (("conditions", name), ("jacobian", name), ("nearest", name, "--q", q, "--evaluations", "100")):
        check(printed(capsys, *line), "")
