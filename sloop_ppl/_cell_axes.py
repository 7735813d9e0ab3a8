"""Read tables over cells by their coordinates, whichever way their axes were turned.

Shape legend: H, W grid.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeGuard, TypeVar

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError

if TYPE_CHECKING:
    import xarray

    from sloop_ppl.maps.grid import Grid

__all__ = ["by_coordinate", "has_cell_axes", "in_order"]

Labelled = TypeVar("Labelled", "xarray.DataArray", "xarray.Dataset")

_CLOSE = 1e-3  # of a cell: how far a coordinate may lie from the centre of its cell


def has_cell_axes(table: Any) -> TypeGuard[xarray.DataArray]:
    """Tell whether a table is an xarray one with x and y among its dims."""
    return hasattr(table, "coords") and {"x", "y"} <= set(map(str, getattr(table, "dims", ())))


def in_order(table: Any, what: str, grid: Grid | None = None) -> Any:
    """Return a table of xarray as `by_coordinate` does, and any other as it is."""
    return by_coordinate(table, what, grid) if has_cell_axes(table) else table


def by_coordinate(table: Labelled, what: str, grid: Grid | None = None) -> Labelled:
    """Return a table with its cells in the order of the grid: y from the south, x from the west.

    Parameters
    ----------
    table
        Dims y and x, the centres of cells as its coordinates, metres, in any order.
    what
        What to call it in messages.
    grid
        The cells it should have; when None, any evenly spaced ones.

    Raises
    ------
    InputError
        When a coordinate is missing, given twice or no number, cells are missing, or they are
        others than the grid's.
    """
    for axis in ("x", "y"):
        if axis not in table.coords:
            raise InputError(
                f"{what} has no coordinate {axis}; expected the centres of its cells, metres"
            )
        try:
            centres = np.asarray(table.coords[axis].values, dtype=np.float64)
        except (TypeError, ValueError):
            centres = np.array([np.nan])
        order = np.argsort(centres)
        centres = centres[order]
        if not np.isfinite(centres).all() or (np.diff(centres) <= 0).any():
            raise InputError(
                f"{what} has no different finite numbers as its coordinate {axis}; expected the "
                "centres of its cells, metres"
            )
        _check_centres(centres, axis, what, grid)
        if (np.diff(order) != 1).any():  # a table in order keeps its layout, and so every bit
            table = table.isel({axis: order})
    return table.transpose(..., "y", "x")


def _check_centres(centres: NDArray[np.float64], axis: str, what: str, grid: Grid | None) -> None:
    """Refuse other centres than those of the grid, in words that tell cut from coarse."""
    steps = np.diff(centres)
    if grid is None:
        if steps.size and not np.allclose(steps, steps[0], rtol=_CLOSE):
            raise InputError(
                f"{what} lacks cells: its coordinate {axis} is unevenly spaced ({steps.min():g} to "
                f"{steps.max():g} m); expected every cell of the map"
            )
        return
    expected = grid.x_m if axis == "x" else grid.y_m
    close = _CLOSE * grid.cell_m
    if centres.size == expected.size and np.allclose(centres, expected, rtol=0, atol=close):
        return
    found = f"its {axis} starts at {centres[0]:g} m, expected {expected[0]:g} m"
    if centres.size != expected.size or abs(centres[0] - expected[0]) <= close:
        found = (
            f"along {axis} there are {centres.size} from {centres[0]:g} to {centres[-1]:g} m, "
            f"expected {expected.size} from {expected[0]:g} to {expected[-1]:g} m"
        )
    raise InputError(f"{what}: {found}; give the whole table on the map's own cells")
