"""Draw where a target is believed to be."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.plots._axes import font_pt, new_axes, quote_texts, set_title, stroke, width_in
from sloop_ppl.plots._belief import check_cells, draw_cells, draw_hpd, mode_of
from sloop_ppl.plots._frame_arrows import draw_frames
from sloop_ppl.plots._marks import add_legend
from sloop_ppl.plots._palette import ACCENTS, INK, MUTED, PAPER
from sloop_ppl.plots._protocols import GroundsLike, PosteriorLike
from sloop_ppl.plots.city import draw_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage

    from sloop_ppl.plots._labels import LabelLayer

__all__ = ["add_colour_bar", "add_mark", "plot_belief", "plot_beliefs"]

_LEAST_SHARE = 0.02
"""Places that are less probably meant are not marked."""


def plot_belief(
    posterior: PosteriorLike,
    target: str,
    *,
    ax: Axes | None = None,
    truth: tuple[float, float] | None = None,
    labels: bool = True,
    legend: bool = True,
    colour_bar: bool = True,
    title: str | None = None,
) -> Axes:
    """Draw the belief of one target over the map, with what was said about it marked.

    Parameters
    ----------
    posterior
        Beliefs over the cells of a map.
    target
        Id of the target.
    ax
        Axes to draw on; a new pyplot figure when None.
    truth
        x and y of the true place, metres, or None when it is not known.
    labels
        True to name landmarks; those mentioned come first.
    legend
        True to add a legend.
    colour_bar
        True to add a colour bar, in probability per cell.
    title
        Title of the axes; the target's id when None.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, in metres, limits at the borders of the cells.

    Raises
    ------
    UnknownName
        When the posterior has no such target.
    InputError
        When the belief has another shape than the map, or is not finite.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> post = sloop.infer("The red bike is near Ivy.", "cleveland")
    >>> plot_belief(post, "RedBike").get_xlabel()
    "east of the map's centre (m)"
    """
    if target not in posterior.targets:
        raise UnknownName("target", target, posterior.targets)
    axes = new_axes(ax, height=6.6 if colour_bar else 6.9)
    handles, layer = _draw(axes, posterior, target, truth, labels, colour_bar)
    set_title(axes, title or target)
    if legend:
        add_legend(axes, handles, layer)
    return axes


def plot_beliefs(
    posterior: PosteriorLike, *, truths: Mapping[str, tuple[float, float]] | None = None
) -> Figure:
    """Draw the belief of every target, one panel each, under what was said.

    Parameters
    ----------
    posterior
        Beliefs over the cells of a map.
    truths
        True places of targets, metres, as far as they are known.

    Returns
    -------
    matplotlib.figure.Figure
        A figure that pyplot does not hold; save it or show it in a notebook.

    Raises
    ------
    InputError
        When there is no target.
    """
    from matplotlib.figure import Figure

    count = len(posterior.targets)
    if count == 0:
        raise InputError("The posterior holds no target; describe at least one")
    # One wide panel, or two columns of panels that fit a page in landscape.
    cols = 1 if count == 1 else 2
    rows = -(-count // cols)
    width, height = (6.8, 7.3) if count == 1 else (11.0, 5.0 * rows + 0.9)
    figure = Figure(figsize=(width, height), layout="constrained")
    panels = figure.subplots(rows, cols, squeeze=False).flat
    known = truths or {}
    handles: dict[str, Any] = {}
    for panel, target in zip(panels, posterior.targets, strict=False):
        drawn, _ = _draw(panel, posterior, target, known.get(target), True, True)
        handles.update({str(h.get_label()): h for h in drawn})
        panel.set_title(target, fontsize=10, color=INK, pad=5)
    for panel in list(figure.axes)[: rows * cols][count:]:
        panel.set_axis_off()
    quote_texts(figure, posterior.texts, width)
    figure.legend(
        handles=list(handles.values()),
        loc="outside lower center",
        ncol=min(len(handles), 3 if count == 1 else 6),
        fontsize=8.5,
        frameon=False,
        labelcolor=INK,
    )
    return figure


def _draw(
    ax: Axes,
    posterior: PosteriorLike,
    target: str,
    truth: tuple[float, float] | None,
    labels: bool,
    colour_bar: bool,
) -> tuple[list[Any], LabelLayer]:
    """Draw one target's panel; return handles for a legend and the layer of its labels."""
    from matplotlib.colors import to_rgb
    from matplotlib.patches import Patch

    city = posterior.city
    belief = check_cells(posterior.belief(target), city, f"The belief of '{target}'")
    relations = posterior.relations(target)
    shares = _shares(posterior, target)
    mentioned = (g for relation in relations for g in relation.grounds if g in city)
    open_grounds = sorted(shares, key=lambda ground: -shares[ground])
    grounds = [*(g for g in mentioned if g not in shares), *open_grounds]
    layer = draw_map(
        ax, city, labels=labels, highlight=grounds, muted=True, cells=True, shares=shares
    )
    image = draw_cells(ax, belief, city.grid)
    handles = draw_hpd(ax, belief, city.grid)
    mode = mode_of(belief, city.grid)
    handles.append(add_mark(ax, mode, "*", ACCENTS["mode"], "most probable cell"))
    points = [mode]
    if truth is not None:
        handles.append(add_mark(ax, truth, "D", ACCENTS["truth"], "true place"))
        points.append((float(truth[0]), float(truth[1])))
    if grounds:
        face = (*to_rgb(ACCENTS["mentioned"]), 0.13)
        handles.append(
            Patch(facecolor=face, edgecolor=ACCENTS["mentioned"], lw=1.2, label="mentioned")
        )
    arrows, along = draw_frames(ax, city, posterior.frames(target))
    handles.extend(arrows)
    layer.avoid(points=[*points, *along])
    if colour_bar:
        add_colour_bar(ax, image)
    return handles, layer


def _shares(posterior: PosteriorLike, target: str) -> dict[str, float]:
    """Return landmark -> probability that it is meant, of those of which that is not certain."""
    if not isinstance(posterior, GroundsLike):
        return {}
    open_: dict[str, float] = {}
    certain: set[str | None] = set()
    for ground in posterior.grounds(target):
        places = [c for c in ground.candidates if c.ground in posterior.city]
        if len(ground.candidates) == 1 or ground.relation.negated:
            certain |= {c.ground for c in places}
            continue
        for place in places:
            if place.p >= _LEAST_SHARE:
                open_[place.ground] = max(open_.get(place.ground, 0.0), place.p)
    return {ground: p for ground, p in open_.items() if ground not in certain}


def add_mark(ax: Axes, place: tuple[float, float], marker: str, colour: str, label: str) -> Any:
    """Put a marker with a white rim at a place and return it as a handle."""
    size = {"*": 11.0, "D": 5.5}[marker] * stroke(ax)
    style: Any = {"ls": "none", "marker": marker, "ms": size, "mfc": colour, "mec": PAPER}
    style |= {"mew": 1.0, "label": label, "zorder": 5.0, "scalex": False, "scaley": False}
    return ax.plot([place[0]], [place[1]], **style)[0]


def add_colour_bar(ax: Axes, image: AxesImage, label: str = "probability per cell") -> None:
    """Add a colour bar in per cent beside a map."""
    from matplotlib.ticker import FuncFormatter

    figure = ax.get_figure()
    if figure is None:
        return
    size = font_pt(width_in(ax))
    percent = FuncFormatter(lambda p, _: f"{100 * p:.3g} %")
    bar = figure.colorbar(image, ax=ax, shrink=0.6, aspect=28, pad=0.02, format=percent)
    bar.ax.set_facecolor(MUTED.ground)
    bar.set_label(label, fontsize=size, color=INK)
    bar.ax.tick_params(labelsize=size - 0.5, width=0.6, length=2.5, labelcolor=INK)
    bar.outline.set_linewidth(0.6)
