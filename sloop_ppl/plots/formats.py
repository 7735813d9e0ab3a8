"""Check figure paths, and write figures so that equal input gives equal bytes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from sloop_ppl.errors import InputError, OutputError
from sloop_ppl.outputs import check_output, written_whole
from sloop_ppl.plots._glyphs import collected_glyphs, tell_missing, use_fallback_fonts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["animation_formats", "check_figure_path", "figure_formats", "save_figure"]

_FIGURES = ("jpg", "pdf", "png", "svg")
_ANIMATIONS = ("gif", "mp4")
# Dates and versions, which would make equal figures differ.
_METADATA: dict[str, dict[str, Any]] = {
    "pdf": {"CreationDate": None},
    "png": {"Software": None},
    "svg": {"Date": None},
}


def figure_formats() -> tuple[str, ...]:
    """Return the endings that :func:`save_figure` accepts, in alphabetical order."""
    return _FIGURES


def animation_formats() -> tuple[str, ...]:
    """Return the endings that :func:`animate_search` accepts, in alphabetical order."""
    return _ANIMATIONS


def check_figure_path(path: str | Path, *, animation: bool = False) -> Path:
    """Return `path` as a Path when a figure can be written there; check before the work is done.

    Parameters
    ----------
    path
        Where the figure is to go.
    animation
        True for an animation, whose endings are others.

    Raises
    ------
    InputError
        When the ending is unknown; choose one of those named.
    OutputError
        When the folder is missing or cannot be written to, or the path is a folder.

    Examples
    --------
    >>> check_figure_path("belief.png").suffix
    '.png'
    """
    chosen = Path(path)
    known = _ANIMATIONS if animation else _FIGURES
    if chosen.suffix.lower().removeprefix(".") not in known:
        what = "Animation" if animation else "Figure"
        ending = f"has the ending '{chosen.suffix}'" if chosen.suffix else "has no ending"
        raise InputError(
            f"{what} path '{path}' {ending}; expected one of {', '.join(f'.{k}' for k in known)}"
        )
    return check_output(chosen, (chosen.suffix.lower(),))


def save_figure(drawn: Figure | Axes, path: str | Path, *, dpi: float = 200.0) -> Path:
    """Write a figure, or the figure of an axes, with nothing in it that differs between runs.

    Parameters
    ----------
    drawn
        What the functions of this package return.
    path
        Where it goes; the ending chooses the format.
    dpi
        Dots per inch of raster formats, > 0.

    Raises
    ------
    InputError
        When the ending is unknown.
    OutputError
        When the file cannot be written.
    """
    import matplotlib as mpl
    from matplotlib.axes import Axes

    chosen = check_figure_path(path)
    figure = drawn.get_figure(root=True) if isinstance(drawn, Axes) else drawn
    if figure is None:
        raise InputError("The axes belong to no figure any more; draw again and save the result")
    try:
        missing = _write(figure, chosen, dpi, mpl.rcParams["font.family"])
        if missing and (fonts := use_fallback_fonts(figure, missing)):
            missing = _write(figure, chosen, dpi, [*mpl.rcParams["font.family"], *fonts])
    except OSError as error:
        raise OutputError(
            f"Figure '{path}' cannot be written: {error.strerror or error}"
        ) from error
    tell_missing(missing, f"Figure '{path}'")
    return chosen


def _write(figure: Figure, path: Path, dpi: float, fonts: list[str]) -> set[str]:
    """Write a figure; return the letters that the fonts of its texts lack."""
    import matplotlib as mpl

    ending = path.suffix.lower().removeprefix(".")
    # A fixed salt: matplotlib draws ids of SVG elements at random without one.
    with (
        collected_glyphs() as missing,
        mpl.rc_context({"svg.hashsalt": "sloop", "font.family": fonts}),
        written_whole(path) as whole,
    ):
        figure.savefig(
            whole, format=ending, dpi=dpi, bbox_inches="tight", metadata=_METADATA.get(ending)
        )
    return missing
