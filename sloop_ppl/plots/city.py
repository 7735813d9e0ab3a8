"""Draw a city map that people recognise."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import shapely

from sloop_ppl.maps import PATH_KINDS, CityMap, Landmark
from sloop_ppl.plots._axes import frame_map, new_axes, stroke
from sloop_ppl.plots._ground import draw_ground, draw_shape
from sloop_ppl.plots._marks import (
    add_attribution,
    add_legend,
    add_north_arrow,
    add_scale_bar,
)
from sloop_ppl.plots._palette import ACCENTS, CLEAR, INK, MUTED, PAPER, MapPalette

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from sloop_ppl.plots._labels import Label, LabelLayer

__all__ = ["draw_map", "plot_map"]


def plot_map(
    city: CityMap,
    *,
    ax: Axes | None = None,
    labels: bool = True,
    grid: bool = False,
    highlight: Sequence[str] = (),
    muted: bool = False,
    legend: bool = True,
) -> Axes:
    """Draw a map: buildings, roads, parks, parking, points of interest and their names.

    Parameters
    ----------
    city
        The map.
    ax
        Axes to draw on; a new pyplot figure 6.6 inches wide when None.
    labels
        True to write the names, each where it is free; those without room are dropped.
    grid
        True to draw the borders of the cells; the limits are then those of the cells, which
        overhang the map's extent in the east and the south.
    highlight
        Ids of landmarks to outline and to name before all others.
    muted
        True for greys, to lay something over.
    legend
        True to add a legend of what the colours mean.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, in metres, north up.

    Raises
    ------
    UnknownName
        When a landmark to highlight is not on the map.

    Examples
    --------
    >>> from sloop_ppl.maps import load_map
    >>> plot_map(load_map("cleveland")).get_ylabel()
    "north of the map's centre (m)"
    """
    axes = new_axes(ax)
    layer = draw_map(axes, city, labels=labels, grid=grid, highlight=highlight, muted=muted)
    if legend:
        add_legend(axes, _key(city, MUTED if muted else CLEAR, bool(highlight)), layer)
    return axes


def draw_map(
    ax: Axes,
    city: CityMap,
    *,
    labels: bool = True,
    grid: bool = False,
    highlight: Sequence[str] = (),
    muted: bool = False,
    cells: bool = False,
    furniture: bool = True,
    view_m: tuple[float, float, float, float] | None = None,
    shares: Mapping[str, float] | None = None,
) -> LabelLayer:
    """Draw a map without a legend and return the layer that holds its labels.

    Parameters
    ----------
    ax, city, labels, grid, highlight, muted
        As in :func:`plot_map`.
    cells
        True for limits that show every cell whole.
    furniture
        True to add a scale bar, a north arrow and the attribution.
    view_m
        West, south, east and north limit, metres, of a part of the map; None for all of it.
    shares
        Highlighted landmark -> probability that it is meant, where that is not certain: its
        outline is as opaque, and its label says it.
    """
    from sloop_ppl.plots._labels import LabelLayer

    mentioned = [city.landmark(m) for m in dict.fromkeys(highlight)]
    palette = MUTED if muted else CLEAR
    whole = city.grid.cells_extent_m if grid or cells else city.grid.extent_m
    frame_map(ax, view_m or whole)
    draw_ground(ax, city, palette)
    if grid:
        _draw_grid(ax, city)
    for landmark in mentioned:
        _outline(ax, city, landmark, _opacity((shares or {}).get(landmark.id, 1.0)))
    wanted = _labels(city, mentioned, palette, shares or {}) if labels else []
    layer = LabelLayer(wanted)
    ax.add_artist(layer)
    layer.set_clip_path(None)
    if furniture:
        layer.avoid(add_scale_bar(ax), add_north_arrow(ax))
    credit = add_attribution(ax, city) if furniture else None
    if credit is not None:
        layer.avoid(credit)
    return layer


def display_name(landmark: Landmark) -> str:
    """Return a landmark's name, or its id taken apart into words."""
    if landmark.name:
        return landmark.name
    # CamelCase apart: between lower and upper case or digit, and before the last of a run of
    # capitals.
    return re.sub(r"(?<=[a-z])(?=[A-Z0-9])|(?<=[A-Z])(?=[A-Z][a-z])", " ", landmark.id)


def _draw_grid(ax: Axes, city: CityMap) -> None:
    west, south, east, north = city.grid.cells_extent_m
    half = city.grid.cell_m / 2
    style = {"color": INK, "linewidth": 0.3, "alpha": 0.28, "zorder": 1.5}
    ax.vlines([*(city.grid.x_m - half), east], south, north, **style)  # type: ignore[arg-type]
    ax.hlines([*(city.grid.y_m - half), north], west, east, **style)  # type: ignore[arg-type]


def _opacity(share: float) -> float:
    """Return how opaque a landmark is that is meant with some probability; it can be seen."""
    return 0.25 + 0.75 * share


def _outline(ax: Axes, city: CityMap, landmark: Landmark, opacity: float = 1.0) -> None:
    """Outline a landmark; for a point, the building whose cells it takes, too."""
    from matplotlib.patheffects import withStroke

    shape = landmark.geometry
    colour = ACCENTS["mentioned"]
    if shape.geom_type == "Point":
        ax.scatter(
            [shape.x],
            [shape.y],
            s=26 * stroke(ax) ** 2,
            color=colour,
            edgecolor=PAPER,
            linewidth=0.8,
            alpha=opacity,
            zorder=3.2,
        )
        shape = city.footprint(landmark.id)
    if landmark.kind in PATH_KINDS and "Line" in shape.geom_type:
        from sloop_ppl.plots._ground import road_width_m

        shape = shape.buffer(road_width_m(landmark) / 2, cap_style="flat")
    shape = shapely.make_valid(shape) & shapely.box(*city.grid.extent_m)
    draw_shape(ax, shape, 1.0, colour, alpha=0.13 * opacity)
    halo = [withStroke(linewidth=2.6 * stroke(ax), foreground=PAPER, alpha=0.7)]
    draw_shape(ax, shape, 3.0, edge=colour, points=1.3, path_effects=halo, alpha=opacity)


def _labels(
    city: CityMap,
    mentioned: Sequence[Landmark],
    palette: MapPalette,
    shares: Mapping[str, float],
) -> list[Label]:
    """Return the labels of a map, most wanted first."""
    from sloop_ppl.plots._labels import Label

    names = [
        f"{display_name(m)} {shares[m.id]:.0%}" if m.id in shares else display_name(m)
        for m in mentioned
    ]
    wanted = [
        Label(name, m.geometry, ACCENTS["mentioned"], 1.06, "bold", must=True)
        for name, m in zip(names, mentioned, strict=True)
    ]
    mentioned_ids = {m.id for m in mentioned}
    window = shapely.box(*city.grid.extent_m)
    named = [
        m
        for m in city.landmarks
        if m.name
        and "…" not in m.name
        and m.id not in mentioned_ids
        and window.intersects(m.geometry)
    ]  # an ellipsis marks a name that was cut off in the source
    for landmark in sorted(named, key=lambda m: _rank(m, window)):
        # Sizes beside 1: side streets and places are smaller than the street that leads to them.
        colour, size, style = palette.label, 1.0, "normal"
        if landmark.kind in PATH_KINDS:
            colour, size = palette.road_label, 0.97 if landmark.kind == "street" else 0.85
        elif landmark.kind == "park":
            colour, style = palette.park_label, "italic"
        elif landmark.kind == "water":
            colour, style = palette.water_label, "italic"
        elif landmark.kind == "poi":
            colour, size = palette.poi, 0.85
        text = display_name(landmark)
        wanted.append(Label(text, landmark.geometry, colour, size, "normal", style))
    return wanted


def _rank(landmark: Landmark, window: Any) -> tuple[int, float, str]:
    """Return the sort key of a label: streets, areas by size, then points."""
    seen = shapely.intersection(shapely.make_valid(landmark.geometry), window)
    if landmark.kind in PATH_KINDS:
        return (0 if landmark.kind == "street" else 2), -seen.length, landmark.id
    return (1 if seen.area > 0 else 3), -seen.area, landmark.id


def _key(city: CityMap, palette: MapPalette, mentioned: bool) -> list[Any]:
    """Return one legend handle for each kind of thing that is on the map."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    def patch(label: str, face: str, edge: str, **more: Any) -> Any:
        return Patch(facecolor=face, edgecolor=edge, linewidth=0.6, label=label, **more)

    counts = city.counts()
    handles: list[Any] = []
    if "building" in counts:
        handles.append(patch("building", palette.building, palette.building_edge))
    if "street" in counts or "service" in counts:
        handles.append(patch("street, service road", palette.road, palette.road_edge))
    if "pedestrian" in counts:
        handles.append(
            Line2D([], [], color=palette.pedestrian, ls=(0, (3, 2)), lw=1, label="footway")
        )
    if "parking" in counts:
        handles.append(patch("parking", palette.parking, palette.parking_edge, hatch="/////"))
    if "park" in counts:
        handles.append(patch("green", palette.park, palette.park_edge))
    if "water" in counts:
        handles.append(patch("water", palette.water, palette.water_edge))
    if "square" in counts:
        handles.append(patch("square", palette.square, palette.road_edge))
    if "poi" in counts:
        handles.append(
            Line2D([], [], ls="none", marker="o", ms=4, mfc=palette.poi, mec=PAPER, label="place")
        )
    if mentioned:
        handles.append(patch("mentioned", "none", ACCENTS["mentioned"]))
    return handles
