"""Search for the targets of a posterior: the facade over the search room."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.inference import Posterior
from sloop_ppl.maps import CityMap
from sloop_ppl.rng import child
from sloop_ppl.search import SearchConfig, run_search
from sloop_ppl.search.names import check_planner

if TYPE_CHECKING:
    from sloop_ppl.search import Episode, Step

__all__ = ["imagined_places", "search"]


def search(
    posterior: Posterior,
    city: CityMap,
    places: Mapping[str, tuple[float, float]] | None = None,
    planner: str = "pouct",
    sims: int = 1000,
    sensor_range_cells: float = 3,
    start: tuple[float, ...] | None = None,
    *,
    rng: np.random.Generator,
    config: SearchConfig | None = None,
    on_step: Callable[[Step], None] | None = None,
    keep_beliefs: bool = False,
) -> Episode:
    """Search the map for the targets of a posterior, all of them jointly.

    Parameters
    ----------
    posterior : what is believed about where the targets are.
    city : the map the posterior was made on.
    places : true place of each target, x and y in metres. One that is not given is drawn from
        the posterior and named in `Episode.imagined`.
    planner : name of a planner; see `sloop list planners`.
    sims : simulations per step, > 0.
    sensor_range_cells : how far the sensor sees, cells, >= 1.
    start : x and y in metres and, if given, heading in degrees; drawn when None.
    rng : where start, imagined places, environment and planner draw from.
    config : the other settings; `sims` and `sensor_range_cells` take the place of its own.
    on_step : called with every step when it is done.
    keep_beliefs : keep the beliefs after every step in the episode.

    Returns
    -------
    Episode
        Poses, actions, observations, rewards and what was found.

    Raises
    ------
    InputError : when the posterior was made on another map, or a place is of no target.
    OutsideMap : when a place or the start is outside the map.
    UnknownName : when there is no such planner.
    """
    check_planner(planner)
    if posterior.city.digest != city.digest:
        raise InputError(
            f"The posterior was made on another map ('{posterior.city.name}', "
            f"{posterior.city.grid.shape} cells); expected '{city.name}' as it is now; infer it "
            "again on this map"
        )
    imagined = imagined_places(posterior, places or {}, rng=rng)
    settings = replace(
        config or SearchConfig(), sims=sims, sensor_range_cells=float(sensor_range_cells)
    )
    episode = run_search(
        {target: posterior.belief(target) for target in posterior.targets},
        city,
        {**(places or {}), **imagined},
        planner=planner,
        config=settings,
        start=start,
        rng=rng,
        on_step=on_step,
        keep_beliefs=keep_beliefs,
    )
    return replace(episode, imagined=tuple(imagined))


def imagined_places(
    posterior: Posterior, known: Mapping[str, tuple[float, float]], *, rng: np.random.Generator
) -> dict[str, tuple[float, float]]:
    """Draw a place from the posterior for each target whose place is not known.

    Returns
    -------
    dict
        Target -> x and y of a cell's centre that lies inside the map, metres.
    """
    grid = posterior.city.grid
    inside = np.array([[grid.contains(x, y) for x in grid.x_m] for y in grid.y_m]).reshape(-1)
    drawn = {}
    for target in posterior.targets:
        if target not in known:
            weights = posterior.belief(target).reshape(-1) * inside
            cell = child(rng, "place", target).choice(grid.size, p=weights / weights.sum())
            drawn[target] = grid.centre_of(*divmod(int(cell), grid.n_cols))
    return drawn
