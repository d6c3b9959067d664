"""Where a text has the rows of a Denavit–Hartenberg table: the readers of all written forms, in their order.

- Calls of toolboxes: `Link([theta d a alpha])`, `Link('d', 0.1, 'a', 0, 'alpha', pi/2)`, `RevoluteMDH(d=0.1, a=0)`.
- A table with a heading that names its columns, as it is printed, in CSV, Markdown, or as a comment above an array.
- Names in each row: `{'a': 0, 'd': 0.1, 'alpha': pi/2}`, `dict(a=0, d=0.1, alpha=pi/2)`.
- A list for each parameter: `a = [0, -0.425, …]`, `d = […]`, `alpha = […]`.
- Numbered names: `a1 = 0.4`, `alpha1 = -pi/2`, or `{alpha0: 0, a0: 0, d1: 0.75, …}`.

The entries stay texts; `dh_text` makes an arm of them.
"""

from __future__ import annotations

from rankdrop.errors import RobotError
from rankdrop.robot.dh_calls import table_of_calls
from rankdrop.robot.dh_headed import table_with_heading
from rankdrop.robot.dh_latex import plain_latex
from rankdrop.robot.dh_lists import table_of_lists, table_of_numbered_names
from rankdrop.robot.dh_named import table_of_named_rows
from rankdrop.robot.dh_written import WrittenTable, plain_letters


def table_in(text: str, file: str) -> WrittenTable | None:
    """The table that a text has; None where it has none.

    Raises:
        RobotError: two arms, or a row that does not fit.
    """
    plain = plain_latex(plain_letters(text)).replace("$", "")
    lines = plain.splitlines()
    return (
        table_of_calls(lines, file)
        or table_with_heading(lines)
        or table_of_named_rows(lines, file)
        or table_of_lists(lines, file)
        or table_of_numbered_names(lines)
    )


def is_table(text: str) -> bool:
    """Whether a text has a table."""
    try:
        return table_in(text, "") is not None
    except RobotError:
        return True  # its reader says why it cannot be read
