"""Word a table for the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sloop_ppl.eval._tables import Table

if TYPE_CHECKING:
    from rich.console import RenderableType

__all__ = ["table_lines"]


def table_lines(table: Table) -> list[RenderableType]:
    """Return a table with its title above and its notes below, for printing."""
    from rich.table import Table as Drawn

    drawn = Drawn(box=None, pad_edge=False, header_style="bold")
    for name, right in zip(table.head, table.numeric(), strict=True):
        drawn.add_column(name, justify="right" if right else "left")
    for row in table.texts():
        drawn.add_row(*row)
    return [table.title, drawn, *table.notes, ""]
