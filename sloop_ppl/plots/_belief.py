"""Lay a belief over a map: its cells, the borders of its HPD regions and its mode."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap, Grid
from sloop_ppl.plots._axes import stroke
from sloop_ppl.plots._ground import draw_shape
from sloop_ppl.plots._palette import INK, PAPER, belief_colours

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage

__all__ = ["check_cells", "draw_cells", "draw_hpd", "hpd_region", "mode_of", "region_outline"]

# Share of the peak below which a cell is left clear, so that the map shows through.
_NEGLIGIBLE = 5e-3
# Relative difference up to which probabilities count as equal: equal cells differ by rounding.
_TIE = 1e-9


def check_cells(values: NDArray[np.float64], city: CityMap, what: str) -> NDArray[np.float64]:
    """Return an array over a map's cells as float64.

    Raises
    ------
    InputError
        When it has another shape than the map's grid, or a value that is not finite.
    """
    array = np.asarray(values, dtype=np.float64)
    if array.shape != city.grid.shape:
        raise InputError(
            f"{what} has shape {array.shape}; expected {city.grid.shape}, the cells of map "
            f"'{city.name}'"
        )
    if not np.isfinite(array).all():
        raise InputError(f"{what} has a value that is not finite; expected finite numbers")
    return array


def hpd_region(belief: NDArray[np.float64], mass: float) -> NDArray[np.bool_]:
    """Return the smallest set of most probable cells that holds `mass`; ties come in together.

    Parameters
    ----------
    belief
        Probabilities, shape (H, W), sum one.
    mass
        Mass in (0, 1].
    """
    # Cells from the most probable down until their sum reaches the mass; all as probable come too.
    ordered = np.sort(belief, axis=None)[::-1]
    needed = int(np.searchsorted(np.cumsum(ordered), mass * belief.sum() * (1 - _TIE)))
    floor = ordered[min(needed, ordered.size - 1)]
    region: NDArray[np.bool_] = belief >= floor * (1 - _TIE)
    return region & (belief > 0)


def region_outline(region: NDArray[np.bool_], grid: Grid) -> Any:
    """Return the border of a set of cells as shapely lines in metres, empty for no cell."""
    west, south, _, _ = grid.cells_extent_m
    # A ring of False, so that regions on the border of the grid are closed.
    ringed = np.pad(region, 1)
    # An edge runs wherever two neighbours differ; lattice points are counted from the south-west.
    row, col = np.nonzero(ringed[1:-1, 1:] != ringed[1:-1, :-1])
    upright = np.stack([col, row, col, row + 1], axis=1)
    row, col = np.nonzero(ringed[1:, 1:-1] != ringed[:-1, 1:-1])
    level = np.stack([col, row, col + 1, row], axis=1)
    ends = np.concatenate([upright, level]).reshape(-1, 2, 2) * grid.cell_m + (west, south)
    if not len(ends):
        return shapely.LineString()
    lines = shapely.line_merge(shapely.multilinestrings(shapely.linestrings(ends)))
    # Takes the corners out of straight runs; 1e-6 of a cell keeps the steps.
    parts = shapely.simplify(shapely.get_parts(lines), grid.cell_m * 1e-6)
    return shapely.multilinestrings(parts)


def mode_of(belief: NDArray[np.float64], grid: Grid) -> tuple[float, float]:
    """Return the centre of the most probable cell; of equals, the one nearest to their mean."""
    rows, cols = np.nonzero(belief >= belief.max() * (1 - _TIE))
    x, y = grid.x_m[cols], grid.y_m[rows]
    middle = int(np.argmin((x - x.mean()) ** 2 + (y - y.mean()) ** 2))
    return float(x[middle]), float(y[middle])


def draw_cells(
    ax: Axes, values: NDArray[np.float64], grid: Grid, *, zorder: float = 2.0, **style: Any
) -> AxesImage:
    """Draw values over the cells of a map, row 0 in the south; the limits are left alone.

    Parameters
    ----------
    values
        Shape (H, W); cells below half a per cent of the greatest are left clear unless `style`
        holds a ``norm`` or a ``vmin`` of its own.
    """
    west, south, east, north = grid.cells_extent_m
    limits = ax.get_xlim(), ax.get_ylim()
    shown: Any = values
    if "norm" not in style and "vmin" not in style:
        top = float(values.max())
        shown = np.ma.masked_less(values, _NEGLIGIBLE * top)
        style = {"vmin": 0.0, "vmax": top or 1.0, **style}
    style = {"cmap": belief_colours(), "interpolation": "nearest", **style}
    image = ax.imshow(
        shown, origin="lower", extent=(west, east, south, north), zorder=zorder, **style
    )
    ax.set_xlim(*limits[0])
    ax.set_ylim(*limits[1])
    return image


def draw_hpd(ax: Axes, belief: NDArray[np.float64], grid: Grid, *, colour: str = INK) -> list[Any]:
    """Draw the borders of the 50 and 90 % HPD regions and return handles for a legend."""
    from matplotlib.lines import Line2D
    from matplotlib.patheffects import withStroke

    handles: list[Any] = []
    # The narrower region last and solid, on top of the wider one.
    for mass, dashes, points in ((0.9, (0, (3.2, 1.8)), 0.9), (0.5, "solid", 1.1)):
        width = points * stroke(ax)
        border = region_outline(hpd_region(belief, mass), grid)
        halo = [withStroke(linewidth=width + 1.1, foreground=PAPER, alpha=0.75)]
        style: Any = {"linestyle": dashes, "path_effects": halo, "gid": f"hpd-{mass * 100:.0f}"}
        draw_shape(ax, border, 3.4, edge=colour, points=points, **style)
        label = f"{mass * 100:.0f} % HPD region"
        handles.append(Line2D([], [], color=colour, ls=dashes, lw=width, label=label))
    return handles[::-1]
