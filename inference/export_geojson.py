"""Write beliefs as cells with probabilities that any GIS opens: GeoJSON in WGS84."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap
from sloop_ppl.models import ObservationModel
from sloop_ppl.outputs import check_output, written_whole

__all__ = ["cells_geojson", "write_geojson"]

_DECIMALS = 8  # about a millimetre


class Beliefs(Protocol):
    """What is written: a Posterior, or anything that has as much of it."""

    @property
    def city(self) -> CityMap:
        """The map."""

    @property
    def model(self) -> ObservationModel:
        """The observation model."""

    @property
    def texts(self) -> tuple[str, ...]:
        """The texts of the descriptions."""

    @property
    def targets(self) -> tuple[str, ...]:
        """Ids of the targets."""

    def belief(self, target: str) -> NDArray[np.float64]:
        """Return the probability of each cell, shape (H, W)."""


def cells_geojson(posterior: Beliefs, targets: Sequence[str], least: float = 0.0) -> dict[str, Any]:
    """Return a FeatureCollection with one square per cell and target.

    Parameters
    ----------
    posterior
        What is believed.
    targets
        Ids of the targets.
    least
        Cells of a lower probability are left out, in [0, 1).

    Returns
    -------
    dict
        Features with the properties ``target``, ``probability``, ``density_per_m2``, ``hpd``
        (mass of the smallest HPD region that holds the cell, so ``hpd <= 0.9`` styles the 90 %
        region), ``row`` (from the south), ``col`` and the centre ``x_m``, ``y_m``. Rings go
        anticlockwise, and neighbours share corners exactly.

    Raises
    ------
    InputError
        When the map has no centre on earth, or `least` is no probability.
    UnknownName
        When there is no such target.

    Notes
    -----
    Source: RFC 7946.
    """
    grid = posterior.city.grid
    if grid.centre is None:
        raise InputError(
            f"Map '{posterior.city.name}' has no centre on earth, so its cells have no longitude; "
            "give its grid a centre=(lat, lon)"
        )
    if not 0 <= least < 1:
        raise InputError(f"least is {least}; expected a probability in [0, 1)")
    half = grid.cell_m / 2
    corners = np.meshgrid(
        np.append(grid.x_m - half, grid.x_m[-1] + half),
        np.append(grid.y_m - half, grid.y_m[-1] + half),
    )
    lonlat = np.round(np.stack(grid.to_lonlat(*corners), -1), _DECIMALS)
    features = []
    for target in targets:
        belief = posterior.belief(target)
        order = np.argsort(-belief, axis=None, kind="stable")
        region = np.empty(belief.size)
        region[order] = np.minimum(np.cumsum(belief.reshape(-1)[order]), 1.0)
        for row, col in zip(*np.nonzero(belief >= least), strict=True):
            p = float(belief[row, col])
            ring = [lonlat[row + i, col + j] for i, j in ((0, 0), (0, 1), (1, 1), (1, 0), (0, 0))]
            features.append(
                {
                    "type": "Feature",
                    "geometry": {"type": "Polygon", "coordinates": [[c.tolist() for c in ring]]},
                    "properties": {
                        "target": target,
                        "probability": p,
                        "density_per_m2": p / grid.cell_m**2,
                        "hpd": float(region[row * grid.n_cols + col]),
                        "row": int(row),
                        "col": int(col),
                        "x_m": float(grid.x_m[col]),
                        "y_m": float(grid.y_m[row]),
                    },
                }
            )
    return {
        "type": "FeatureCollection",
        "name": f"belief on {posterior.city.name}",
        "attribution": posterior.city.attribution,
        "model": posterior.model.name,
        "texts": list(posterior.texts),
        "features": features,
    }


def write_geojson(posterior: Beliefs, path: str | Path, least: float = 0.0) -> None:
    """Write the cells of every target to a ``.geojson`` or ``.json`` file, whole or not at all."""
    target = check_output(path, (".geojson", ".json"))
    cells = cells_geojson(posterior, posterior.targets, least)
    with written_whole(target) as temporary:
        temporary.write_text(json.dumps(cells, ensure_ascii=False) + "\n", encoding="utf-8")
