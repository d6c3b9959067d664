"""How the Jacobian of a link is printed."""

from __future__ import annotations

from rankdrop.cli import exits


def test_a_singular_configuration_has_no_inverse(run) -> None:
    ended = run("jacobian", "planar2r", "--q", "0.3,0", "--inverse")
    assert ended.code == exits.UNEXPLAINED
    assert "no inverse: the configuration is singular" in ended.out
