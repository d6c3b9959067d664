"""Updates a second of the viewer: what a slider does at once, the explanation behind it, both while an arm moves."""

from __future__ import annotations

from time import sleep

import measure  # first: sets the number of threads
import numpy as np

from rankdrop.results.explanation import Explanation
from rankdrop.results.known import shipped
from rankdrop.verbs.explain import explain
from rankdrop.viewer.panel import details_html, status_html
from rankdrop.viewer.scene import Live, Now
from rankdrop.viewer.session import Session

TARGET = 30.0  # updates a second


class Panel:
    """Makes the texts of the panel and throws them away."""

    def __init__(self, live: Live) -> None:
        self.live = live

    def shown(self, now: Now, source: object) -> None:
        """As `rankdrop.viewer.panel` does."""
        status_html(now, self.live.robot.n, self.live.generic_rank, len(self.live.families))

    def explained(self, found: Explanation) -> None:
        """As `rankdrop.viewer.panel` does."""
        details_html(found)

    def failed(self, error: BaseException) -> None:
        """Stop the benchmark."""
        raise SystemExit(f"failed: {error}")


def main() -> None:
    """Random configurations and witnesses of families; then a session on a moving arm, its explanations included."""
    count, seconds = (20, 0.5) if measure.quick() else (300, 3.0)
    rows = []
    for name in ("puma560", "ur5", "pa10", "gen3", "fetch8"):
        found = shipped(name)
        live = Live(found.robot, found.task, found.families)
        regular = np.random.default_rng(0).uniform(-2.0, 2.0, (count, live.robot.n))
        singular = np.array([family.witness for family in found.families])

        def look(q: np.ndarray, live: Live = live) -> None:
            for one in q:
                live.look(one)

        def whole(live: Live = live, q: np.ndarray = regular) -> None:
            assert all(explain(live.robot, one, live.task).verdict for one in q[:10])  # computed when it is read

        rows.append({
            "arm": name, "look, regular /s": count / measure.best_of(3, lambda look=look, q=regular: look(q)),
            "look, singular /s": len(singular) / measure.best_of(3, lambda look=look, q=singular: look(q)),
            "explain /s": 10 / measure.best_of(1, whole), **moving(live, seconds),
        })  # fmt: skip
    measure.report(
        "viewer: 30 updates a second at a singular configuration, the slowest kind", rows, ratio="look, singular /s",
        target=TARGET,
    )  # fmt: skip


def moving(live: Live, seconds: float) -> dict[str, float]:
    """Looks and explanations a second while sliders are dragged as fast as a session takes it."""
    session = Session(live, Panel(live), np.full(live.robot.n, 0.3))
    session.start()
    sleep(0.5)
    looked, thought = session.looked, session.thought
    for i in range(int(seconds * 100)):
        session.set_joint(i % live.robot.n, 0.3 + 0.002 * i)
        sleep(0.01)
    rates = (session.looked - looked) / seconds, (session.thought - thought) / seconds
    session.close()
    return {"dragged: looks /s": rates[0], "dragged: explained /s": rates[1]}


if __name__ == "__main__":
    main()
