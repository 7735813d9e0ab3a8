"""The package's colours as a page's: a style sheet of variables, and tables of colours."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import asdict
from functools import cache
from importlib.resources import files

import numpy as np

from sloop_ppl.plots._palette import (
    ACCENTS,
    DARK,
    MUTED,
    TARGET_COLOURS,
    MapPalette,
    belief_colours,
    belief_colours_on_dark,
    difference_colours,
)

__all__ = ["colour_tables", "static_text", "style_sheet", "view_sheet"]


@cache
def static_text(name: str) -> str:
    """Return a file of the folder ``static``."""
    return (files("sloop_ppl") / "web" / "static" / name).read_text(encoding="utf-8")


@cache
def view_sheet() -> str:
    """Return the style sheet of the map and its controls: the palette's variables, then rules."""
    light, dark = _variables(MUTED), _variables(DARK)
    accents = "".join(f"--accent-{name}:{colour};" for name, colour in ACCENTS.items())
    targets = "".join(f"--target-{i}:{colour};" for i, colour in enumerate(TARGET_COLOURS))
    return (
        f".sloop{{{light}{accents}{targets}}}\n"
        f"@media (prefers-color-scheme: dark){{:root:not([data-theme=light]) .sloop{{{dark}}}}}\n"
        f":root[data-theme=dark] .sloop{{{dark}}}\n"
    ) + static_text("view.css")


@cache
def style_sheet() -> str:
    """Return the style sheet of every page: that of the view, then the pages' own rules."""
    return view_sheet() + static_text("style.css")


@cache
def colour_tables() -> dict[str, str]:
    """Return tables of RGBA bytes in base64: beliefs (256 colours) and differences (255)."""
    t = np.linspace(0, 1, 256)
    tables = {
        "belief": belief_colours()(t),
        "belief_dark": belief_colours_on_dark()(t),
        "difference": difference_colours()(np.linspace(0, 1, 255)),
    }
    return {
        name: b64encode((255 * np.asarray(rgba)).round().astype(np.uint8).tobytes()).decode()
        for name, rgba in tables.items()
    }


def _variables(palette: MapPalette) -> str:
    return "".join(
        f"--map-{name.replace('_', '-')}:{colour};" for name, colour in asdict(palette).items()
    )
