"""Hostile and broken XML is refused with its line; what is harmless is read."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rankdrop.errors import RobotError
from rankdrop.robot import files
from rankdrop.robot.files import read_xml
from rankdrop.robot.urdf import from_urdf

BILLION_LAUGHS = """<?xml version="1.0"?>
<!DOCTYPE robot [
 <!ENTITY a "ha">
 <!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">
 <!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;">
]>
<robot name="&c;"/>"""


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (BILLION_LAUGHS, 2),
        ('<?xml version="1.0"?>\n<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/hostname">]>\n<r a="1">&x;</r>', 2),
        ('<!DOCTYPE r SYSTEM "http://127.0.0.1/x.dtd"><r/>', 1),
        ('<!DOCTYPE r [<!ENTITY % p SYSTEM "file:///etc/hostname"> %p;]><r/>', 1),
        ("<!DOCTYPE robot><robot/>", 1),
    ],
)
def test_document_types_and_entities_are_refused(text: str, line: int) -> None:
    with pytest.raises(RobotError, match="document types and entities are refused") as caught:
        from_urdf(text, file="x.urdf")
    assert str(caught.value).startswith(f"x.urdf, line {line}: ")


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("<robot>\n<link>\n</robot>", 3, "mismatched tag"),
        ("<robot>\n<link name='a' name='b'/></robot>", 2, "duplicate attribute"),
        ("<robot>\n<link name='&x;'/></robot>", 2, "undefined entity"),
        ("<robot/>\n<robot/>", 2, "junk after document element"),
        ("<robot", 1, "unclosed token"),
        ("", 1, "no element found"),
        ("<robot>\0</robot>", 1, "invalid token"),
    ],
)
def test_broken_xml_is_refused_with_its_line(text: str, line: int, words: str) -> None:
    with pytest.raises(RobotError, match=f"^x, line {line}: this is not well-formed XML: .*{words}"):
        read_xml(text, "x")


def test_depth_is_limited() -> None:
    assert read_xml("<a>" * 100 + "</a>" * 100, "x").tag == "a"
    with pytest.raises(RobotError, match="line 1: the elements are nested too deeply; allowed: depth 100"):
        read_xml("<a>" * 100_000, "x")


def test_depth_is_limited_inside_what_is_left_out() -> None:
    with pytest.raises(RobotError, match="nested too deeply"):
        read_xml("<r><skip>" + "<a>" * 1000, "x", frozenset({"skip"}))


def test_number_of_elements_and_size_are_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "MOST_ELEMENTS", 50)
    with pytest.raises(RobotError, match="too many elements"):
        read_xml("<r>" + "<a/>" * 50 + "</r>", "x")
    monkeypatch.setattr(files, "LARGEST_FILE", 1000)
    with pytest.raises(RobotError, match="too large"):
        read_xml("<r>" + " " * 1000 + "</r>", "x")


def test_elements_know_their_lines_and_their_prefixes() -> None:
    root = read_xml("<?xml version='1.0'?>\n<r>\n  <drake:a x='1'/>\n  <b/></r>", "x")
    assert [(child.tag, child.line) for child in root.children] == [("drake:a", 3), ("b", 4)]
    assert root.children[0].attributes == {"x": "1"}


def test_what_is_left_out_leaves_its_neighbours() -> None:
    root = read_xml("<r><a><s/><b/></a><s><a><s/></a></s><c/></r>", "x", frozenset({"s"}))
    assert [child.tag for child in root.children] == ["a", "c"]
    assert [child.tag for child in root.children[0].children] == ["b"]
    with pytest.raises(RobotError, match="no element"):
        read_xml("<s/>", "x", frozenset({"s"}))


@given(st.text(max_size=80))
def test_any_text_gives_an_element_or_a_robot_error(text: str) -> None:
    with suppress(RobotError):
        assert read_xml(f"<r>{text}</r>", "x").tag == "r"


def test_an_external_file_is_not_read(tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_text("<link name='stolen'/>", encoding="utf-8")
    text = f'<robot xmlns:xi="http://www.w3.org/2001/XInclude"><xi:include href="{secret}"/></robot>'
    assert "stolen" not in str(read_xml(text, "x"))
