"""How often the drone's detectors err: a sweep over poses around targets, on several maps."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sloop_ppl.maps import CityMap
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.pose import HEADINGS
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.rng import child
from sloop_ppl.simulation import (
    Camera,
    Drone,
    Look,
    SensorRates,
    World,
    flight_plan,
    make_detector,
    measured_rates,
    nearest_free,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["CameraScore", "sweep_camera", "sweep_figure", "sweep_lines"]

_LOOKS = (
    Look("car", "red"), Look("bike", "green"), Look("van", "blue"), Look("person", "orange"),
    Look("car", "yellow"), Look("bike", "purple"),
)  # fmt: skip
_BANDS = 4
"""Distances of 0 to 1, 1 to 2, 2 to 3, 3 to 4 cells."""


class CameraScore:
    """What a detector did over the poses of a sweep.

    Parameters
    ----------
    detector, altitude_m
        Which, and how high.
    in_view, detected
        Looks at targets in the planner's view, and those that were reported from a cell in view.
    out_of_view, false_reports
        Looks with a target out of view, and those that reported it nonetheless.
    wrong_cell
        Reports from another cell than the target's.

    Attributes
    ----------
    errors_m
        Distance between reported and true place of each report in view.
    by_distance
        Looks and detections by distance in cells, rounded down, shape (4, 2).
    by_kind
        The same by kind of target.
    """

    def __init__(
        self,
        detector: str,
        altitude_m: float,
        *,
        in_view: int = 0,
        detected: int = 0,
        out_of_view: int = 0,
        false_reports: int = 0,
        wrong_cell: int = 0,
    ) -> None:
        self.detector, self.altitude_m = detector, altitude_m
        self.in_view, self.detected = in_view, detected
        self.out_of_view, self.false_reports = out_of_view, false_reports
        self.wrong_cell = wrong_cell
        self.errors_m: list[float] = []
        self.by_distance: Any = np.zeros((_BANDS, 2), dtype=int)
        self.by_kind: dict[str, list[int]] = {}

    def rates(self) -> SensorRates:
        """Return the rates that the planner's sensor model gets.

        Notes
        -----
        The sigma is that at which a cell's four neighbours together get the share of wrong cells.
        """
        wrong = self.wrong_cell / max(self.detected, 1)
        # p = 4 w / (1 + 4 w) with w = exp(-1 / (2 sigma^2)).
        w = min(max(wrong / (4 * max(1 - wrong, 1e-9)), 1e-6), 0.99)
        return SensorRates(
            round(self.detected / max(self.in_view, 1), 3),
            round(self.false_reports / max(self.out_of_view, 1), 4),
            round(math.sqrt(-1 / (2 * math.log(w))), 2),
        )

    def to_json(self) -> dict[str, Any]:
        """Return counts, rates and errors as JSON values."""
        rates, errors = self.rates(), self.errors_m or [math.inf]
        return {
            "detector": self.detector,
            "altitude_m": self.altitude_m,
            "in_view": self.in_view,
            "true_positive_rate": rates.true_positive,
            "out_of_view": self.out_of_view,
            "false_positive_rate": rates.false_positive,
            "wrong_cell": round(self.wrong_cell / max(self.detected, 1), 3),
            "position_noise_cells": rates.position_noise_cells,
            "median_error_m": _finite(np.median(errors)),
            "error_95_m": _finite(np.quantile(errors, 0.95)),
            "by_distance": [
                round(hits / looks, 3) if looks else None for looks, hits in self.by_distance
            ],
            "by_kind": {k: round(hits / looks, 3) for k, (looks, hits) in self.by_kind.items()},
        }


def sweep_camera(
    cities: Sequence[CityMap],
    *,
    altitudes_m: Sequence[float] = (14.0, 10.0),
    detectors: Sequence[str] = ("camera", "segmentation", "rays"),
    poses: int = 60,
    seed: int = 0,
    notify: Callable[[str], None] = lambda line: None,  # noqa: ARG005
) -> list[CameraScore]:
    """Look at targets from many poses and count.

    Parameters
    ----------
    cities
        The maps; each gets six targets of four kinds in six colours.
    altitudes_m
        How high the drone hangs.
    detectors
        Names of detectors.
    poses
        Poses of each map and altitude, of which two of three have a target in view.
    seed
        Decides targets and poses.
    notify
        Called with a line of progress after each map and altitude.
    """
    scores = {(d, a): CameraScore(d, a) for a in altitudes_m for d in detectors}
    for city in cities:
        rng = child(np.random.default_rng(seed), "camera", city.name)
        world = _world(city, rng, seed)
        for altitude in altitudes_m:
            of_altitude = [scores[d, altitude] for d in detectors]
            _look_around(world, altitude, of_altitude, poses, rng)
            notify(f"{city.name} at {altitude:g} m")
    return list(scores.values())


def sweep_figure(scores: Sequence[CameraScore]) -> Figure:
    """Return a figure: detection rates by distance beside the planner's, and position errors.

    Bars are the 95 % intervals of Wilson.
    """
    from matplotlib.figure import Figure
    from scipy.stats import binomtest

    from sloop_ppl.plots._palette import TARGET_COLOURS

    figure = Figure(figsize=(9.5, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    for score, colour in zip(scores, TARGET_COLOURS, strict=False):
        label = f"{score.detector}, {score.altitude_m:g} m"
        looks, hits = score.by_distance.T
        used = looks > 0
        share = hits[used] / looks[used]
        tests = [binomtest(int(k), int(n)) for n, k in score.by_distance[used]]
        ends = np.array([test.proportion_ci(method="wilson") for test in tests]).reshape(-1, 2)
        spread = np.abs(ends.T - share)
        x = np.arange(_BANDS)[used] + 0.5 + 0.04 * (len(left.containers) - 2.5)
        left.errorbar(x, share, yerr=spread, color=colour, marker="o", ms=4, label=label)
        left.axhline(measured_rates(score.detector).true_positive, color="0.2", lw=0.9, ls=":")
        errors = np.sort(score.errors_m)
        if len(errors):
            right.plot(errors, np.arange(1, len(errors) + 1) / len(errors), color=colour)
    left.set(xlabel="distance from the drone, cells", ylabel="detected of those in view")
    left.set(ylim=(0, 1.03), xlim=(0, _BANDS))
    left.set_title("Detection; dotted: the planner's rate", fontsize=10)
    left.legend(fontsize=7.5, frameon=False, loc="lower left")
    right.set(xlabel="distance of the report from the truth, m", ylabel="share of reports")
    right.set(xlim=(0, 2), ylim=(0, 1.03))
    right.set_title("Position", fontsize=10)
    return figure


def sweep_lines(scores: Sequence[CameraScore]) -> list[str]:
    """Return a table of scores as lines of text."""
    lines = [
        "detector      altitude  in view  detected   false  wrong cell  median error   95 %",
    ]
    for score in scores:
        r = score.to_json()
        lines.append(
            f"{score.detector:<13} {score.altitude_m:>6g} m {score.in_view:>8} "
            f"{r['true_positive_rate']:>9.3f} {r['false_positive_rate']:>7.4f} "
            f"{r['wrong_cell']:>11.3f} {r['median_error_m'] or math.nan:>11.2f} m "
            f"{r['error_95_m'] or math.nan:>5.2f} m"
        )
    return lines


def _finite(value: Any) -> float | None:
    return round(float(value), 3) if math.isfinite(value) else None


def _world(city: CityMap, rng: np.random.Generator, seed: int) -> World:
    west, south, east, north = city.grid.extent_m
    places, looks = {}, {}
    for i, look in enumerate(_LOOKS):
        at = rng.uniform((west + 5, south + 5), (east - 5, north - 5))
        name = f"Target{i + 1}"
        places[name] = nearest_free(city, (float(at[0]), float(at[1])), 1.5)
        looks[name] = look
    return World.from_map(city, places, looks=looks, seed=seed)


def _look_around(
    world: World,
    altitude_m: float,
    scores: Sequence[CameraScore],
    poses: int,
    rng: np.random.Generator,
) -> None:
    config, sensor = flight_plan(world.city, SearchConfig(), altitude_m, "camera")
    space = SearchSpace.of_city(world.city, tuple(world.places), config, sensor=sensor)
    grid = world.city.grid
    cells = {t: grid.cell_at(*place) for t, place in world.places.items()}
    free = [c for c in range(space.n_cells) if c not in space.no_fly]
    drone = Drone(world, (0.0, 0.0), altitude_m=60.0, wind_m_s=2.0, rng=rng)
    with Camera(world, drone) as camera:
        looking = {s.detector: make_detector(s.detector, camera) for s in scores}
        for number in range(poses):
            wanted = [*cells.values()][int(rng.integers(len(cells)))]
            for _ in range(2000 if number % 3 else 1):
                cell, heading = int(rng.choice(free)), int(rng.integers(HEADINGS))
                planned = space.pose_at(cell * HEADINGS + heading)
                if sensor.view(planned)[wanted]:
                    break
            drone.put(planned.x_m, planned.y_m, altitude_m, planned.heading_rad)
            drone.hover(seconds=0.3)
            believed, true = drone.estimated_pose, drone.pose
            view = sensor.view(
                planned._replace(
                    x_m=true.x_m, y_m=true.y_m, heading_rad=true.yaw_rad % (2 * math.pi)
                )
            )
            usable = sensor.view(
                planned._replace(
                    x_m=believed.x_m, y_m=believed.y_m, heading_rad=believed.yaw_rad % (2 * math.pi)
                )
            )
            for score in scores:
                found = {d.target: d for d in looking[score.detector].detect()}
                for name, where in cells.items():
                    _count(score, world, name, where, view, usable, found.get(name), planned)


def _count(
    score: CameraScore, world: World, name: str, cell: tuple[int, int], view: Any, usable: Any,
    found: Any, planned: Any,
) -> None:  # fmt: skip
    grid = world.city.grid
    reported = None
    if found is not None and grid.contains(*found.place):
        at = grid.cell_at(*found.place)
        reported = at if usable[at] else None
    if not view[cell]:
        score.out_of_view += 1
        score.false_reports += reported is not None
        return
    row, col = grid.cell_covering(planned.x_m, planned.y_m)
    band = min(int(math.hypot(cell[0] - row, cell[1] - col)), _BANDS - 1)
    kind = score.by_kind.setdefault(world.looks[name].kind, [0, 0])
    score.in_view += 1
    score.by_distance[band, 0] += 1
    kind[0] += 1
    if reported is None:
        return
    score.detected += 1
    score.by_distance[band, 1] += 1
    kind[1] += 1
    score.wrong_cell += reported != cell
    score.errors_m.append(math.dist(found.place, world.places[name]))
