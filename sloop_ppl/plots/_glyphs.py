"""Take letters that the font of a figure lacks from another font, or say which are missing."""

from __future__ import annotations

import logging
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["collected_glyphs", "tell_missing", "use_fallback_fonts"]

_LOG = logging.getLogger(__name__)
# What matplotlib says for every letter and every time it is drawn.
_GLYPH = re.compile(r"Glyph (\d+)")
# Letters that a message shows.
_SHOWN = 12


@contextmanager
def collected_glyphs() -> Iterator[set[str]]:
    """Collect the letters that no font of the texts has, in place of matplotlib's warnings."""
    missing: set[str] = set()
    with warnings.catch_warnings(record=True) as caught:
        # Other warnings keep their filters, and are given on below.
        warnings.filterwarnings("always", message=_GLYPH.pattern)
        yield missing
    for warning in caught:
        if found := _GLYPH.match(str(warning.message)):
            missing.add(chr(int(found[1])))
        else:
            warnings.warn_explicit(
                warning.message, warning.category, warning.filename, warning.lineno
            )


def use_fallback_fonts(figure: Figure, missing: set[str]) -> list[str]:
    """Let the texts of a figure take letters that are missing from other installed fonts.

    Return the names of these fonts, fewest that have all that any has; the texts must be drawn in
    a context in which they are in ``font.family``, for labels are made when they are drawn.
    """
    from matplotlib import rcParams
    from matplotlib.text import Text

    fonts = _fonts_with(missing)
    if fonts:
        usual = list(rcParams["font.family"])
        for text in figure.findobj(Text):
            if isinstance(text, Text) and text.get_fontfamily() == usual:
                text.set_fontfamily([*usual, *fonts])
        for layer in figure.findobj(lambda artist: hasattr(artist, "forget")):
            layer.forget()  # type: ignore[attr-defined]  # labels placed in the other font
    return fonts


def tell_missing(missing: set[str], what: str) -> None:
    """Log one line on the letters that no installed font has."""
    if missing:
        shown = " ".join(sorted(missing)[:_SHOWN]) + (" …" if len(missing) > _SHOWN else "")
        _LOG.warning(
            "%s: no installed font has %d of its letters, drawn as boxes: %s; install one that "
            "has, such as Noto Sans CJK", what, len(missing), shown,
        )  # fmt: skip


def _fonts_with(letters: set[str]) -> list[str]:
    """Return the installed fonts that have some letters, the one that has most of them first."""
    from matplotlib import font_manager

    has: dict[str, set[str]] = {}
    for entry in font_manager.fontManager.ttflist:
        # The last resort, which matplotlib brings, has a box for every letter.
        if entry.style != "normal" or entry.name in has or entry.name.startswith("Last Resort"):
            continue
        try:
            charmap = font_manager.get_font(entry.fname).get_charmap()
        except (OSError, RuntimeError):  # a font that has been removed, or is damaged
            continue
        has[entry.name] = {letter for letter in letters if ord(letter) in charmap}
    chosen: list[str] = []
    left = set(letters)
    while left and has:
        best = max(sorted(has), key=lambda name: len(has[name] & left))
        if not has[best] & left:
            break
        chosen.append(best)
        left -= has[best]
    return chosen
