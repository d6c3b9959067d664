"""Nobody from another origin, nobody from another machine without the token."""

from __future__ import annotations

import pytest

from rankdrop.viewer.access import Gate, new_token

HERE = Gate(8765)
OPEN = Gate(8765, "secret")


@pytest.mark.parametrize("host", ["127.0.0.1:8765", "localhost:8765", "[::1]:8765", "LocalHost:8765"])
def test_loopback_names_pass(host: str) -> None:
    assert HERE.refuses("/", {"Host": host}) is None
    assert HERE.refuses("/", {"Host": host, "Origin": f"http://{host}"}) is None


@pytest.mark.parametrize("host", ["evil.example:8765", "127.0.0.1", "127.0.0.1:80", "", "localhost.evil.example:8765"])
def test_rebound_names_are_refused(host: str) -> None:
    assert "loopback" in str(HERE.refuses("/", {"Host": host}))


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://localhost:3000", "file://", ""])
def test_other_origins_are_refused(origin: str) -> None:
    assert "other pages" in str(HERE.refuses("/", {"Host": "localhost:8765", "Origin": origin}))


def test_exposed_needs_the_token_in_the_address_or_the_cookie() -> None:
    host = {"Host": "lab-pc:8765"}
    assert OPEN.refuses("/", host) is not None
    assert OPEN.refuses("/?token=wrong", host) is not None
    assert OPEN.refuses("/?token=", host) is not None
    assert OPEN.refuses("/?token=secret", host) is None
    cookie = OPEN.cookie("/?token=secret")
    assert cookie == "rankdrop-8765=secret; HttpOnly; SameSite=Strict; Path=/"
    assert OPEN.refuses("/", {**host, "Cookie": "a=b; rankdrop-8765=secret"}) is None
    assert OPEN.refuses("/", {**host, "Cookie": "rankdrop-8766=secret"}) is not None
    assert OPEN.refuses("/", {**host, "Cookie": "rankdrop-8765=wrong"}) is not None


def test_the_token_does_not_open_the_door_to_other_pages() -> None:
    assert OPEN.refuses("/?token=secret", {"Host": "lab-pc:8765", "Origin": "http://evil.example"}) is not None


def test_a_loopback_viewer_sets_no_cookie() -> None:
    assert HERE.cookie("/?token=secret") is None


def test_tokens_differ_and_are_long() -> None:
    assert new_token() != new_token()
    assert len(new_token()) >= 20
