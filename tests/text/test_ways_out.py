"""How ways out of a singularity are worded."""

from __future__ import annotations

from rankdrop.robot.open import open_robot
from rankdrop.text.words import superscript
from rankdrop.verbs.explain import explain


def test_ways_out_of_a_high_order_are_printed() -> None:
    """Where σ hangs on the tolerance the order told can be high, whatever it is worth; it is printed all the same."""
    q = [0.6100307872216834, -0.824415084239536, 1.0001106043034938e-05, -0.8428645262277553, 1.5792702331388404,
         -1.668953371799625]  # fmt: skip
    found = explain(open_robot("stanford"), q, "scara")
    orders = [one.order for one in found.escape.single if one.order]
    rows = next(section.rows for section in found.sections(full=True) if section.title == "How to get out")
    assert sum(" per " in " ".join(row) for row in rows) == len(orders)
    assert [superscript(k) for k in (2, 5, 12)] == ["²", "⁵", "¹²"]
