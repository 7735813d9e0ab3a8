"""Infer on a large map from coarse to fine: cells only where the belief needs them.

The map's cells are gathered into blocks by row and by column. The exact engine weighs the blocks,
each with its number of cells, and rows and columns in which the belief changes are halved until
what is left unresolved is below a bound.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference._belief_summaries import BeliefSummaries
from sloop_ppl.inference.engines import Exact, InferenceInfo
from sloop_ppl.inference.factors import check_description, weigh
from sloop_ppl.inference.posterior import Posterior, check_possible
from sloop_ppl.language import Description, SpatialRelation
from sloop_ppl.maps import CityMap, UnevenGrid
from sloop_ppl.models import ObservationModel, preset

__all__ = ["RefinedPosterior", "infer_refined"]

Table = NDArray[np.float64]

_WIDEST = 16
"""Cells of the widest row or column at first."""

_AROUND_CELLS = ((1, 6), (2, 16), (4, 40), (8, 100))
"""How wide rows and columns are up to how many cells from a place that was mentioned."""

_COMPACT_CELLS = 100
"""Cells up to which a place is one to be surrounded; longer ones are streets, along which there is
nothing to resolve."""

_MOST_MENTIONED = 24
"""Places that are surrounded beforehand; of more, only those that matter are found out."""

_MOST_BLOCKS = 2_000_000
"""Blocks at most: 16 MB a table."""

_ABOUT_M = 500.0
"""How far from what was mentioned other landmarks count, metres."""

_PASSES = 12


@dataclass(frozen=True, eq=False, repr=False)
class RefinedPosterior(BeliefSummaries):
    """A belief over a large map that is fine where the belief changes and coarse elsewhere.

    Parameters
    ----------
    city
        The map.
    blocks
        The posterior over blocks of cells: its components, frames, grounds, readings and lapses
        are those of the description; its `belief` is by block.
    grid
        The blocks.
    info
        How the inference went.
    unresolved
        Estimate of the total variation to the belief that the map's own cells would give.

    Notes
    -----
    `belief` is an ordinary table over the map's cells, and `window` a map of the cells that hold
    most of the belief with the belief on it: these are what plots and searches take. It takes no
    further evidence; describe all in one text, or infer on a window.
    """

    city: CityMap
    blocks: Posterior
    grid: UnevenGrid
    info: InferenceInfo
    unresolved: float
    _beliefs: dict[str, Table] = field(default_factory=dict, init=False)

    def __repr__(self) -> str:
        rows, cols = self.city.grid.shape
        return (
            f"RefinedPosterior({self.city.name!r}, {', '.join(self.targets)}: {rows} x {cols} "
            f"cells in {self.grid.size} blocks, {self.unresolved:.4f} unresolved)"
        )

    @property
    def targets(self) -> tuple[str, ...]:
        """Ids of the targets."""
        return self.blocks.targets

    def belief(self, target: str) -> Table:
        """Return the probability of each cell of the map, summing to one, shape (H, W).

        Raises
        ------
        UnknownName
            When there is no such target.
        """
        if target not in self.targets:
            raise UnknownName("target", target, self.targets)
        if target not in self._beliefs:
            self._beliefs[target] = self.grid.spread(self.blocks.belief(target))
        return self._beliefs[target]

    def window(
        self, target: str, mass: float = 0.95, most_m: float = 5000.0
    ) -> tuple[CityMap, Table]:
        """Return the part of the map that holds a share of the belief, and the belief on it.

        Parameters
        ----------
        target
            Id of the target.
        mass
            How much of the belief it is to hold, in (0, 1].
        most_m
            Its longest side, metres; a belief that needs more is refused.

        Returns
        -------
        tuple
            A map of the same cells and ids, and the belief on it, summing to one.

        Raises
        ------
        InputError
            When no part of that size round the mode holds so much.
        """
        whole, belief = self.city.grid, self.belief(target)
        rows, cols = np.nonzero(self.hpd(target, mass))
        count = int(max(np.ptp(rows), np.ptp(cols))) + 1
        if count * whole.cell_m > most_m:
            raise InputError(
                f"The cells that hold {mass:.0%} of the belief of '{target}' are "
                f"{count * whole.cell_m:,.0f} m apart; expected {most_m:,.0f} at most: ask for "
                "less mass or allow a larger window"
            )
        # On the map's own cells, which are laid from the north-west; half a cell less than whole
        # ones, as a grid has one more than fit between its borders.
        half = (count - 0.5) * whole.cell_m / 2
        west = float(whole.x_m[cols.min()]) - whole.cell_m / 2
        north = float(whole.y_m[rows.max()]) + whole.cell_m / 2
        part = self.city.window((west + half, north - half), 2 * half)
        grid = part.grid
        row, col = whole.cell_covering(float(grid.x_m[0]), float(grid.y_m[0]))
        own = belief[row : row + grid.n_rows, col : col + grid.n_cols]
        return part, own / own.sum()


def infer_refined(
    description: Description,
    city: CityMap,
    model: str | ObservationModel = "bayes",
    *,
    unresolved: float = 0.004,
) -> RefinedPosterior:
    """Return the posterior over the cells of a large map, inferred from coarse to fine.

    Parameters
    ----------
    description
        What was said; its targets start from a uniform prior over the map.
    city
        The map, of cells of 5 m or larger.
    model
        A model's name, or an ObservationModel, that reads phrases by their own.
    unresolved
        Estimated total variation at which refining ends, > 0.

    Returns
    -------
    RefinedPosterior
        The belief; its attribute `unresolved` is what was reached.

    Raises
    ------
    InputError
        When the map's cells are smaller than 5 m, targets are related to each other, the model
        blurs its belief or is given true places, or the belief needs too many blocks.

    Notes
    -----
    Only the fields of the places that were mentioned are made, at the blocks' centres; distances
    are to the same cells as on the map's own grid. The estimate is the change of the belief across
    each block of several cells, by its neighbours.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> city = sloop.load_map("cleveland")
    >>> said = sloop.parse("the red bike is near Ivy", city)
    >>> infer_refined(said, city).belief("RedBike").shape
    (41, 41)
    """
    started = time.perf_counter()
    chosen = preset(model)
    check_description(description, city)
    _check(description, city, chosen, unresolved)
    even = city.grid
    near = _surroundings(description, city)
    columns, rows = _first_edges(description, near)
    for last in range(_PASSES, 0, -1):
        grid = UnevenGrid(
            *even.extent_m, even.cell_m, even.centre,
            tuple(np.flatnonzero(columns).tolist()), tuple(np.flatnonzero(rows).tolist()),
        )  # fmt: skip
        posterior = _on_blocks(description, near, grid, chosen)
        by_col, by_row = _changes(posterior, grid)
        left = float(by_col.sum() + by_row.sum())
        if left <= unresolved or last == 1:
            break
        wanted = 0.5 * unresolved
        finer_columns = _halved(columns, by_col, wanted / 2)
        finer_rows = _halved(rows, by_row, wanted / 2)
        if (finer_columns.sum() - 1) * (finer_rows.sum() - 1) > _MOST_BLOCKS:
            break
        columns, rows = finer_columns, finer_rows
    seconds = time.perf_counter() - started
    spoken_of = {target for f in posterior.factors for target in f.log_factors}
    info = InferenceInfo(
        engine="coarse-to-fine",
        seconds=seconds,
        log_evidence=posterior.log_evidence,
        not_located=tuple(t for t in posterior.targets if t not in spoken_of),
    )
    return RefinedPosterior(city, posterior, grid, info, left)


def _check(
    description: Description, city: CityMap, model: ObservationModel, unresolved: float
) -> None:
    if not unresolved > 0:
        raise InputError(f"unresolved is {unresolved}; expected a total variation above 0")
    if city.grid.cell_m < 5:
        raise InputError(
            f"The map has cells of {city.grid.cell_m:g} m; coarse to fine expects 5 m or more: "
            "use infer on a window"
        )
    if (
        model.needs_truth
        or model.error_m
        or not all(part.is_literal and not part.cut for part in model.components)
    ):
        raise InputError(
            f"Model '{model.name}' is no product of phrases alone; coarse to fine expects one, "
            "such as 'bayes': use infer on a window"
        )
    targets = {target.id for target in description.targets}
    if any(set(r.grounds) & targets for r in _relations(description)):
        raise InputError(
            "The description relates targets to each other; coarse to fine weighs each by itself: "
            "use infer on a window"
        )


def _relations(description: Description) -> list[SpatialRelation]:
    others = (r for reading in description.readings for r in reading.relations)
    return [*description.relations, *others]


def _mentioned(description: Description, city: CityMap) -> list[str]:
    """Return the landmarks that the description may speak of, each once."""
    found: dict[str, None] = {}
    for relation in _relations(description):
        for index, ground in enumerate(relation.grounds):
            found[ground] = None
            for candidate in relation.candidates[index] if relation.candidates else ():
                found[candidate.ground or ""] = None
    return [ground for ground in found if ground in city]


def _surroundings(description: Description, city: CityMap) -> CityMap:
    """Return the map with what was mentioned and what is about it alone.

    Fronts, crossings and blocks are of what is near; of a county's streets they would take longer
    than all else. All parts of a mentioned street stay.
    """
    mentioned = [city.landmark(ground) for ground in _mentioned(description, city)]
    names = {m.name for m in mentioned} - {None, ""}
    about = [shapely.buffer(city.footprint(m.id), _ABOUT_M, quad_segs=2) for m in mentioned]
    longest = _COMPACT_CELLS * city.grid.cell_m + 2 * _ABOUT_M
    compact = [area for area in about if np.ptp(np.reshape(area.bounds, (2, 2)), 0).max() < longest]
    kept = {i for area in about for i in city.reaching_into(area)}
    # What a front depends on stays as it is: how long a street is, too.
    whole = {i for area in compact for i in city.reaching_into(area)}
    whole |= {i for i, m in enumerate(city.landmarks) if m.name in names}
    within = {city.landmarks[i].within for i in kept | whole} - {None}
    whole |= {i for i, m in enumerate(city.landmarks) if m.id in within}
    area, landmarks = shapely.union_all(about), []
    for i in sorted(kept | whole):
        landmark = city.landmarks[i]
        if i not in whole and "LineString" in landmark.geometry.geom_type:
            # Else every street that crosses a long one would cross every other.
            part = shapely.intersection(landmark.geometry, area)
            if "LineString" in part.geom_type and not part.is_empty:
                landmark = replace(landmark, geometry=part)
        landmarks.append(landmark)
    return replace(city, landmarks=tuple(landmarks), _cache={})


def _first_edges(
    description: Description, city: CityMap
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return where columns and rows begin at first: narrow about compact places.

    True at the first cell of each and behind the last cell.
    """
    grid = city.grid
    edges = []
    west, south, _, _ = grid.cells_extent_m
    boxes = [city.footprint(ground).bounds for ground in _mentioned(description, city)]
    if len(boxes) > _MOST_MENTIONED:
        boxes = []
    for axis, (first_m, count) in enumerate(((west, grid.n_cols), (south, grid.n_rows))):
        begins = np.zeros(count + 1, dtype=np.bool_)
        begins[::_WIDEST] = begins[count] = True
        for box in boxes:
            low, high = ((box[axis + k] - first_m) / grid.cell_m for k in (0, 2))
            if high - low > _COMPACT_CELLS:
                continue
            for width, beyond in _AROUND_CELLS:
                start = max(int(low) - beyond, 0) // width * width
                begins[start : min(int(high) + beyond + 1, count) : width] = True
        edges.append(begins)
    return edges[0], edges[1]


def _changes(posterior: Posterior, grid: UnevenGrid) -> tuple[Table, Table]:
    """Return about how much belief each column and each row leaves unresolved, shapes (W,), (H,).

    A block as wide as several cells, across which the density changes by d, misses about a quarter
    of d at each of its cells: half on either side of the middle, by half as much.
    """
    columns, rows = np.zeros(grid.n_cols), np.zeros(grid.n_rows)
    for target in posterior.targets:
        density = posterior.belief(target) / grid.counts
        for axis, centres, edges, sums in (
            (1, grid.x_m, grid.col_edges, columns),
            (0, grid.y_m, grid.row_edges, rows),
        ):
            width = np.diff(edges)
            if len(width) < 2:
                continue
            shape = (1, -1) if axis == 1 else (-1, 1)
            slope = np.abs(np.diff(density, axis=axis)) / np.diff(centres).reshape(shape)
            padding = [(0, 0), (0, 0)]
            padding[axis] = (1, 1)
            slope = np.pad(slope, padding)
            low, high = (slope[:, :-1], slope[:, 1:]) if axis == 1 else (slope[:-1], slope[1:])
            change = np.maximum(low, high) * (width * grid.cell_m).reshape(shape)
            missed = (change * grid.counts).sum(1 - axis) / 8  # total variation is half of it
            sums += np.where(width > 1, missed, 0.0)
    return columns, rows


def _halved(begins: NDArray[np.bool_], missed: Table, wanted: float) -> NDArray[np.bool_]:
    """Return edges between which the widths are halved where most is missed."""
    order = np.argsort(missed)
    # The least, which together miss no more than is wanted, stay as they are.
    split = order[np.cumsum(missed[order]) > wanted]
    edges = np.flatnonzero(begins)
    finer = begins.copy()
    finer[(edges[split] + edges[split + 1]) // 2] = True
    return finer


def _on_blocks(
    description: Description, city: CityMap, grid: UnevenGrid, model: ObservationModel
) -> Posterior:
    """Return the posterior over the blocks of a map."""
    targets = tuple(target.id for target in description.targets)
    uniform = np.log(grid.counts / grid.counts.sum()).reshape(-1)
    log_prior = dict.fromkeys(targets, uniform)
    engine = Exact()
    on_blocks = city.with_grid(grid)
    factor = weigh((description,), on_blocks, model, engine, log_prior)
    posterior = Posterior(
        city=on_blocks,
        model=model,
        method=engine,
        log_prior=log_prior,
        factors=(factor,),
        log_sensed=dict.fromkeys(targets, np.zeros(grid.size)),
    )
    return check_possible(posterior, description)
