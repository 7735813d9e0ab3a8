"""Print how far annotators of frames agree."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sloop_ppl.eval._frame_annotations import FrameAgreement

if TYPE_CHECKING:
    from rich.console import RenderableType

__all__ = ["agreement_lines"]


def agreement_lines(found: FrameAgreement) -> list[RenderableType]:
    """Return a table: all, then each word, each city, and both."""
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in ("word", "city"):
        table.add_column(name)
    for name in ("phrases", "mean", "median", "alpha", "unclear"):
        table.add_column(name, justify="right")
    for row in found.rows:
        table.add_row(
            row.word or "all",
            row.city or "all",
            str(row.units),
            "-" if row.mean_deg is None else f"{row.mean_deg:.1f}°",
            "-" if row.median_deg is None else f"{row.median_deg:.1f}°",
            "-" if row.alpha is None else f"{row.alpha:.3f}",
            f"{100 * row.unclear:.0f} %",
        )
    return [f"Annotators: {', '.join(found.annotators)}", table]
