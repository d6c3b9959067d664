"""What the panel says, as HTML: verdict, σ bars, nearest family, lost motions, joints to blame.

Every word that may come from a file (names of joints, arms, families) is escaped. Colours are Okabe and Ito's; none of
them says anything that a word beside it does not say.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from html import escape
from math import isfinite

from rankdrop.families import Family
from rankdrop.local import Circuit
from rankdrop.results import Explanation, Record
from rankdrop.robot import count
from rankdrop.text import angle, angle_below, lost_text, numbers, short
from rankdrop.viewer.scene import Now

BLUE, ORANGE, GREEN, VERMILION, PURPLE, SKY = "#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9"
VERDICTS = {
    "regular": ("#00664b", "#fff", "●"),
    "near": (ORANGE, "#000", "▲"),
    "singular": ("#ad4400", "#fff", "■"),
    "always-singular": ("#ad4400", "#fff", "■"),
}  # green and vermilion so much darker that white words on them can be read: contrast above 5
CIRCUITS = (ORANGE, PURPLE, GREEN)
"""Of the circuits to blame, the smallest first; further ones take the last."""
_STYLE = "font-size:0.86em;line-height:1.4;padding:0 0.6em 0.5em 0.6em;overflow-wrap:anywhere"
_QUIET = "opacity:0.75"
_FRAMES = 2  # base and tool; `explain` has the link as well


def status_html(
    now: Now, length_of_chain: int, generic_rank: int, titles: Mapping[str, str], explanation: Explanation | None = None
) -> str:
    """Verdict, σ bars, family and distance.

    Args:
        now: what is known at once, with the distance by families.
        length_of_chain, generic_rank: of the arm.
        titles: id of each known family -> its name, the parts of the arm first.
        found: the explanation of this very configuration, once there is one: it gives the verdict, and `details_html`
            family and distance, so that no two lines contradict each other.
    """
    if explanation is None:
        verdict = now.verdict
    else:
        verdict = explanation.verdict
    background, ink, sign = VERDICTS[verdict]
    badge = (
        f'<span style="background:{background};color:{ink};border-radius:0.5em;padding:0.15em 0.6em;'
        f'font-weight:700">{sign} {verdict}</span>'
    )
    idle = length_of_chain - now.seen.rank
    if idle:
        motions = f", {count(idle, 'idle joint motion')}"
    else:
        motions = ""
    lines = [f"{badge} &nbsp;rank {now.seen.rank} of {generic_rank}{motions}",
             *([_family_line(now, titles)] if explanation is None else []), _bars(now, generic_rank)]  # fmt: skip
    if now.outside:
        lines.append(f"<b>beyond a limit:</b> joint {numbers(now.outside)}")
    return lines_html(lines)


def _family_line(now: Now, titles: Mapping[str, str]) -> str:
    if now.family is not None:
        return f"on <b>{name_html(now.family, titles)}</b>"
    first = f"to the singular set {angle(now.distance) if isfinite(now.distance) else 'unknown'}"
    if now.at_least > 0.0:
        first += f", proven: at least {angle_below(now.at_least)}"
    if now.seen.corank:
        if titles:
            first = "on none of the known families"
        else:
            first = "no families are known beforehand"
    if now.nearest is None:
        return first
    return f"{first}<br><span style='{_QUIET}'>nearest family:</span> {name_html(now.nearest, titles)}"


def name_html(family: Family, titles: Mapping[str, str]) -> str:
    """Number and name of a family, the parts of the arm first; of another set its name."""
    if not isinstance(family, Family):
        return escape(family.name)
    return escape(f"{family.id} {titles.get(family.id, family.name)}".strip())


def bar_share(sigma: float, largest: float) -> float:
    """Length of σ's bar, 0 … 1: its share of the largest."""
    if largest > 0:
        return min(1.0, sigma / largest)
    return 0.0


def _bars(now: Now, generic_rank: int) -> str:
    rows = []
    for i, sigma in enumerate(now.sigma, start=1):
        lost = i > now.seen.rank
        if lost:
            colour = VERMILION
        elif sigma <= 1e-3:
            colour = ORANGE
        else:
            colour = BLUE
        width = 100 * bar_share(float(sigma), float(now.sigma[0]))
        if lost and i <= generic_rank:
            note = " lost"
        elif lost:
            note = " never"
        else:
            note = ""
        rows.append(
            f'<div style="display:flex;align-items:center;gap:0.5em"><span style="width:1.8em">σ{i}</span>'
            f'<span style="flex:1;height:0.6em;border-radius:0.3em;background:rgba(128,128,128,0.25)">'
            f'<span style="display:block;height:100%;width:{width:.1f}%;border-radius:0.3em;'
            f'background:{colour}"></span></span>'
            f'<span style="width:7em;text-align:right;font-variant-numeric:tabular-nums">'
            f"{'0' if lost else short(float(sigma), 3)}{note}</span></div>"
        )
    return f'<div style="margin:0.3em 0" title="lengths: shares of σ1">{"".join(rows)}</div>'


def details_html(explanation: Explanation) -> str:
    """What the explanation adds a moment later: its summary, lost motions in two frames, circuits to blame."""
    summary = explanation.sections(parts=("summary",))[-1]
    lines = [f"<b>{escape(summary.title)}</b>", *map(escape, summary.lines)]
    if explanation.lost.words:
        if explanation.verdict != "singular":
            lines.append(f"<span style='{_QUIET}'>at the nearest singular configuration:</span>")
        in_frames = list(explanation.lost.seen.values())[:_FRAMES]
        lines += [_lost_line(lost_text(explanation.robot, lost)) for lost in in_frames]
    return lines_html([*lines, *(_blame_line(i, circuit) for i, circuit in enumerate(explanation.blame.smallest))])


def _blame_line(place: int, circuit: Circuit) -> str:
    """One circuit to blame; `place`: from 0, the smallest first."""
    colour = CIRCUITS[min(place, len(CIRCUITS) - 1)]
    if circuit.words:
        words = f": {escape(circuit.words)}"
    else:
        words = ""
    return (
        f"<span style='{_QUIET}'>to blame:</span> <span style='color:{colour}'>■</span> "
        f"<b>joints {numbers(circuit.numbers)}</b>{words}"
    )


def _lost_line(seen: Record) -> str:
    """What is lost in one frame: what it comes to first, where that can be said, then what every motion obeys."""
    exact = f"the tool can only move so that {escape(', '.join(seen['constraints']))}"
    told = escape(", ".join(words for words in seen['short'] if words))
    return f"<span style='{_QUIET}'>in {escape(seen['axes'])}:</span> " + (
        f"{told}<br><span style='{_QUIET}'>{exact}</span>" if told else exact
    )


def legend_html() -> str:
    """What the arrows and colours mean."""
    items = [
        (VERMILION, "one arrow for each lost motion. ━▶ solid: translation; ┅▶ dotted: rotation; a ring about the foot "
         "of an arrow: the two are mixed, as the sentence says"),
        (SKY, "the same arrow, at a regular configuration: the weakest motion, which is lost first"),
        (ORANGE, "joints to blame and their axes: the smallest circuit"),
        (PURPLE, "the second circuit; a joint of both is drawn in the colour of the first"),
        (f"{VERMILION}88", "seen through: the links as they stand in the nearest singular posture that was found"),
    ]
    rows = "".join(f'<div><span style="color:{colour}">■</span> {text}</div>' for colour, text in items)
    return f'<div style="{_STYLE}">{rows}</div>'


def dimmed_html(content: str) -> str:
    """What was said of another configuration, until the new one is explained."""
    if content:
        return f'<div style="opacity:0.4" aria-hidden="true">{content}</div>'
    return ""


def large_html(title: str, sentence: str) -> str:
    """A title and a sentence to be read from the back of a room."""
    return (
        f'<div style="padding:0.4em 0.6em"><div style="font-size:1.5em;font-weight:700;line-height:1.2">'
        f'{escape(title)}</div><div style="font-size:1.25em;line-height:1.35;margin-top:0.4em">{escape(sentence)}</div>'
        "</div>"
    )


def copy_html(items: Iterable[tuple[str, str]]) -> str:
    """Buttons that copy a text: (label, text) of each."""
    buttons = "".join(f'<button data-copy="{escape(text)}">{escape(label)}</button> ' for label, text in items)
    return f'<div style="{_STYLE}">{buttons}</div>'


def message_html(text: str) -> str:
    """A line of plain text."""
    return f'<div style="{_STYLE}">{escape(text)}</div>'


def lines_html(lines: Iterable[str]) -> str:
    """Lines that are HTML already, words from files in them escaped."""
    return f'<div style="{_STYLE}">{"".join(f"<div>{line}</div>" for line in lines)}</div>'
