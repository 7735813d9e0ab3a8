"""A county made by code: there is no extract of one."""

import numpy as np
import shapely

from sloop_ppl.maps import CityMap, Grid, Landmark


def made_county(half_m, n_buildings, *, cell_m=5.0, spacing_m=400.0, seed=0):
    """Return a square county of streets at right angles, with buildings here and there."""
    rng = np.random.default_rng(seed)
    landmarks = []
    for k, at in enumerate(np.arange(-half_m + spacing_m / 2, half_m, spacing_m)):
        for name, ends in (
            (f"{k} Street", [(at, -half_m), (at, half_m)]),
            (f"{k} Avenue", [(-half_m, at), (half_m, at)]),
        ):
            line = shapely.LineString(ends)
            landmarks.append(Landmark(name.replace(" ", ""), "street", line, name))
    places = rng.uniform(-half_m + 40, half_m - 40, (n_buildings, 2))
    sizes = rng.uniform(8, 30, (n_buildings, 2))
    for i, ((x, y), (w, h)) in enumerate(zip(places, sizes, strict=True)):
        box = shapely.box(x - w, y - h, x + w, y + h)
        landmarks.append(Landmark(f"Hall{i}", "building", box, f"Hall {i}"))
    return CityMap("county", Grid.square(half_m, cell_m), tuple(landmarks))
