"""Read netCDF files; a prior over cells of one: a saved posterior, or a table of one's own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sloop_ppl._cell_axes import by_coordinate, has_cell_axes
from sloop_ppl._foreign import is_file
from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap

if TYPE_CHECKING:
    import xarray

__all__ = ["FileCells", "read_netcdf"]

Table = NDArray[np.float64]

MOST_BYTES = 8 * 2**30
"""Memory that the tables of a file may take."""


def read_netcdf(path: str | Path, what: str) -> xarray.Dataset:
    """Return all that a netCDF file holds; `what` names it in messages.

    Raises
    ------
    InputError
        When it does not exist, is no netCDF, or holds more than `MOST_BYTES`.
    """
    if not is_file(path):
        raise InputError(f"{what} '{path}' cannot be read: no such file")
    import xarray

    try:
        with xarray.open_dataset(Path(path), engine="h5netcdf", decode_times=False) as opened:
            size = opened.nbytes  # a few kilobytes of a file can stand for terabytes
            if size <= MOST_BYTES:
                return opened.load()
    except Exception as error:  # HDF5 and its readers raise nearly anything on damaged files
        raise InputError(f"{what} '{path}' cannot be read: no netCDF, or a damaged one") from error
    raise InputError(
        f"{what} '{path}' holds {size / 2**30:.3g} GiB of tables; expected at most "
        f"{MOST_BYTES / 2**30:g} GiB"
    )


@dataclass(frozen=True, eq=False)
class FileCells:
    """The weights that a file holds.

    Parameters
    ----------
    name
        What to call it in messages.
    belief
        Weights, dims (y, x), or (target, y, x) with the targets' ids. Where it has coordinates x
        and y they are cell centres in metres, in any order, and are checked; without them y is from
        the south. A target it does not hold is anywhere.
    map_name, map_digest
        Name and digest of the map it was made on, checked when there is one.
    """

    name: str
    belief: xarray.DataArray
    map_name: str = ""
    map_digest: str | None = None

    @staticmethod
    def load(path: str | Path) -> FileCells:
        """Read the variable ``belief`` of a netCDF file, such as ``sloop infer --out`` writes.

        Raises
        ------
        InputError
            When it cannot be read, or has no such variable of these dims.
        """
        data = read_netcdf(path, "Prior")
        if "belief" not in data:
            raise InputError(
                f"Prior '{path}' is not a posterior saved by sloop_ppl, nor has it a variable "
                "'belief' of dims (y, x) or (target, y, x); expected one of the two"
            )
        belief = data["belief"]
        if has_cell_axes(belief) and {"x", "y"} <= set(belief.coords):
            belief = belief.transpose(*("target",) * ("target" in belief.dims), "y", "x", ...)
        if belief.dims not in (("y", "x"), ("target", "y", "x")):
            raise InputError(
                f"Prior '{path}' has a 'belief' of dims {belief.dims}; expected (y, x) or "
                "(target, y, x)"
            )
        if "target" in belief.dims and "target" not in belief.coords:
            raise InputError(f"Prior '{path}' does not name its targets; give the dim coordinates")
        digest = data.attrs.get("map_digest")
        made_on = str(data.attrs.get("map", "")), None if digest is None else str(digest)
        return FileCells(str(path), belief, *made_on)

    def __call__(self, city: CityMap, target: str) -> Table:
        """Return the weights for a target, shape (H, W).

        Raises
        ------
        InputError
            When the file was made on another map or other cells.
        """
        if self.map_digest is not None and self.map_digest != city.digest:
            raise InputError(
                f"Prior '{self.name}' was made on another map ('{self.map_name}'); expected "
                f"'{city.name}' as it is now; make it again on this map"
            )
        grid, belief = city.grid, self.belief
        shape = tuple(belief.shape[-2:])
        if shape != grid.shape:
            raise InputError(f"Prior '{self.name}' has shape {shape}; expected {grid.shape}")
        if {"x", "y"} & set(belief.coords):
            what = f"Prior '{self.name}' has other cells than map '{city.name}'"
            belief = by_coordinate(belief, what, grid)
        if "target" in belief.dims:
            if target not in belief["target"]:
                return np.ones(grid.shape)
            belief = belief.sel(target=target)
        if belief.shape != grid.shape:
            raise InputError(f"Prior '{self.name}' names target '{target}' twice; expected once")
        return _numbers(belief, self.name)


def _numbers(belief: xarray.DataArray, name: str) -> Table:
    if belief.dtype.kind not in "fiub":
        raise InputError(f"Prior '{name}' has a 'belief' of {belief.dtype}; expected numbers")
    return np.asarray(belief.values, dtype=np.float64, order="C")
