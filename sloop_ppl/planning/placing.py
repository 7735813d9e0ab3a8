"""Where a search begins and where its targets are: checked, and as poses and cells."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from sloop_ppl.errors import InputError, OutsideMap
from sloop_ppl.maps import Grid
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.rng import child

__all__ = ["start_pose", "true_cells"]


def true_cells(
    ids: tuple[str, ...], places: Mapping[str, tuple[float, float]], grid: Grid
) -> tuple[int, ...]:
    """Return the flat index of each target's cell."""
    if not ids:
        raise InputError("No belief was given; expected one per target that is searched for")
    for name in (*ids, *places):
        if name not in places or name not in ids:
            raise InputError(
                f"'{name}' has {'no place' if name not in places else 'no belief'}; expected a "
                f"place for each of: {', '.join(ids)}"
            )
    cells = []
    for name in ids:
        x, y = _numbers(f"The place of '{name}'", places[name], (2,))
        try:
            row, col = grid.cell_at(x, y)
        except OutsideMap as error:
            raise OutsideMap(f"Target '{name}': {error}") from None
        cells.append(row * grid.n_cols + col)
    return tuple(cells)


def start_pose(
    start: tuple[float, ...] | None, grid: Grid, space: SearchSpace, rng: np.random.Generator
) -> int:
    """Return the pose at which the robot begins."""
    closed = space.no_fly
    if start is None:
        free = [cell for cell in range(space.n_cells) if cell not in closed]
        return free[int(child(rng, "start").integers(len(free)))] * 8
    x, y, *heading = _numbers("The start", start, (2, 3))
    try:
        row, col = grid.cell_at(x, y)
    except OutsideMap as error:
        raise OutsideMap(f"Start: {error}") from None
    if row * space.n_cols + col in closed:
        raise InputError(
            f"Start ({x:g}, {y:g}) is inside a no-fly building; start elsewhere, or fly above "
            f"{space.config.flight_height_m:g} m"
        )
    eighths = heading[0] / 45.0 if heading else 0.0
    if eighths != round(eighths):
        raise InputError(
            f"The start's heading is {heading[0]:g}; expected a multiple of 45 degrees, "
            "anticlockwise from east"
        )
    return space.encode(row, col, round(eighths) % 8)


def _numbers(what: str, value: object, lengths: tuple[int, ...]) -> list[float]:
    """Return a tuple of finite numbers, or say what is wrong with it."""
    try:
        numbers = [float(v) for v in value]  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) not in lengths or not all(math.isfinite(v) for v in numbers):
        form = "x, y" if lengths == (2,) else "x, y or x, y, heading"
        raise InputError(f"{what} is {value!r}; expected {form} as finite numbers")
    return numbers
