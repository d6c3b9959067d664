"""`rankdrop reproduce`: the source documents, item by item."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from rankdrop.cli import exits


def reproduce(
    document: str = "all",
    /,
    *,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    markdown: str | None = None,
    figures: str | None = None,
    full: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
    quiet: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Reproduce the tables, figures, numbers and claims of the five source documents.

    AM: Almarkhi and Maciejewski; ML: Memon's lecture; GR: Gallardo-Alvarado
    and Rico-Martínez; KG: dependent-screw suppression, Canadarm2; JL: Jin's
    lecture. Each item has what is printed, what is computed, and a verdict:
    agrees, rounding, erratum (with the reason), or unreproducible (the document
    does not say enough).

    For example:
        rankdrop reproduce GR
        rankdrop reproduce all --json reproduced.json --figures figures

    Exit code 0: every item has one of these verdicts; 3: some item differs
    without a reason; 2: bad input.

    Args:
        document: AM, ML, GR, KG, JL or all.
        json: Write the items to this file as well; - writes them to stdout in place of the table.
        markdown: Write the page docs/reproduced.md to this file.
        figures: Write the figures into this folder as svg, png and json (the numbers in them).
        full: Whole cells, and the reasons of items that agree as well.
        quiet: No progress.
    """
    from rankdrop.cli.files import check_targets, hand_over, write_bytes, write_json
    from rankdrop.cli.reproduced_table import print_reproduction
    from rankdrop.cli.terminal import reporter
    from rankdrop.reproduce.figures import check_folder, save_figures
    from rankdrop.reproduce.run import markdown as as_page
    from rankdrop.reproduce.run import names
    from rankdrop.reproduce.run import reproduce as run

    check_targets({"--json": json, "--markdown": markdown}, {"--markdown": (".md",)})
    wanted = names(document)
    if figures is not None:
        check_folder(figures)
    with reporter(quiet=quiet) as report:
        found = run(document, progress=report)
        if figures is not None and found.complete:
            save_figures(wanted, figures, progress=report)
    hand_over(
        lambda: print_reproduction(found, full=full),
        (json, lambda target: write_json(found.to_dict(), target)),
        (markdown, lambda target: write_bytes(as_page(found).encode(), target)),
    )
    if not found.complete:
        return exits.INTERRUPTED
    return exits.DIFFERS if found.differs else exits.FINE
