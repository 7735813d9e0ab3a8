"""Small pieces of HTML for notebooks: tables, and maps as SVG; no script, no style sheet.

Legend: H, W grid.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

__all__ = ["beside", "caption", "html_table", "svg_map"]

Points = Iterable[tuple[float, float]]
Extent = tuple[float, float, float, float]

_WIDTH_PX = 240
_MOST_SIDE = 41  # cells of a heat map beyond which it is made coarser
_FAINT = 0.004  # share of the greatest below which a cell is left out


def html_table(rows: Sequence[Sequence[object]], head: Sequence[str] = ()) -> str:
    """Return a table; numbers have four digits."""
    top = "".join(f"<th>{escape(name)}</th>" for name in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(_text(value))}</td>" for value in row) + "</tr>"
        for row in rows
    )
    return f"<table>{f'<thead><tr>{top}</tr></thead>' if head else ''}<tbody>{body}</tbody></table>"


def _text(value: object) -> str:
    if isinstance(value, float | np.floating):
        return f"{value:.4g}"
    return str(value)


def caption(text: str) -> str:
    """Return a line of text to stand above what it is of."""
    return f"<div><b>{escape(text)}</b></div>"


def beside(parts: Sequence[str]) -> str:
    """Return pieces side by side, as far as there is room."""
    each = "".join(
        f'<div style="display:inline-block;margin:0 1em .5em 0">{p}</div>' for p in parts
    )
    return f"<div>{each}</div>"


def svg_map(
    extent_m: Extent,
    *,
    shapes: Iterable[tuple[str, Points]] = (),
    heat: NDArray[np.float64] | None = None,
    path: Sequence[tuple[float, float]] = (),
    marks: Iterable[tuple[float, float, str]] = (),
    title: str = "",
) -> str:
    """Return a drawing in metres, north up.

    Parameters
    ----------
    extent_m
        West, south, east and north, metres; that of the cells where there is `heat`.
    shapes
        Outlines: the style of each, as SVG attributes, and its points in metres.
    heat
        A table over even cells, row 0 in the south, shape (H, W); what is negative is blue, what is
        positive is orange. Tables of more than 41 cells a side are summed by blocks.
    path
        Points of a line, metres.
    marks
        x and y in metres and the colour of each.
    title
        What it shows, for who cannot see it.
    """
    west, south, east, north = extent_m
    scale = _WIDTH_PX / (east - west)
    height = (north - south) * scale

    def at(x: float, y: float) -> str:
        return f"{(x - west) * scale:.1f},{(north - y) * scale:.1f}"

    parts = [f'<rect width="{_WIDTH_PX}" height="{height:.0f}" fill="#f5f4f0"/>']
    for style, points in shapes:
        parts.append(f'<path d="M{" L".join(at(x, y) for x, y in points)}" {style}/>')
    if heat is not None:
        parts += _cells(heat, _WIDTH_PX, height)
    if len(path) > 1:
        line = " ".join(at(x, y) for x, y in path)
        parts.append(f'<polyline points="{line}" fill="none" stroke="#0072b2" stroke-width="1.5"/>')
    for x, y, colour in marks:
        px, py = at(x, y).split(",")
        parts.append(f'<circle cx="{px}" cy="{py}" r="3.5" fill="{colour}" stroke="#fff"/>')
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label="{escape(title)}" '
        f'width="{_WIDTH_PX}" height="{height:.0f}" viewBox="0 0 {_WIDTH_PX} {height:.0f}">'
        f"<title>{escape(title)}</title>{''.join(parts)}</svg>"
    )


def _cells(heat: NDArray[np.float64], width: float, height: float) -> list[str]:
    """Return squares for the cells of a table that are not about 0."""
    rows, cols = heat.shape
    step = max(-(-max(rows, cols) // _MOST_SIDE), 1)
    sums = np.add.reduceat(np.add.reduceat(heat, range(0, rows, step), 0), range(0, cols, step), 1)
    top = float(np.abs(sums).max())
    wide, high = width * step / cols, height * step / rows
    found = []
    for row, col in np.argwhere(np.abs(sums) > _FAINT * top) if top > 0 else ():
        share = float(sums[row, col]) / top
        colour = "#d55e00" if share > 0 else "#0072b2"
        # Rows are counted from the south, pixels from the north.
        y = height * (1 - min((row + 1) * step, rows) / rows)
        found.append(
            f'<rect x="{col * wide:.1f}" y="{y:.1f}" width="{wide:.1f}" height="{high:.1f}" '
            f'fill="{colour}" fill-opacity="{abs(share) ** 0.6:.2f}"/>'
        )
    return found
