"""One described target, searched for on the grid, with rays, or with the camera."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.maps import CityMap
from sloop_ppl.planning import GridEnvironment, SearchConfig, SearchSpace, run_search
from sloop_ppl.planning.environment import start_pose
from sloop_ppl.rng import child
from sloop_ppl.simulation import (
    Camera,
    Drone,
    MujocoEnvironment,
    World,
    flight_plan,
    look_of,
    nearest_free,
    open_share,
)

__all__ = ["ARMS", "Arm", "FlownTarget", "FlownTrial", "trials_of"]

_LEAST_OPEN = 0.02
_WALL_M = 1.5
_MOVED_M = 7.5
"""Targets whose annotated cell has no room for them within this are left out, metres."""


@dataclass(frozen=True)
class Arm:
    """One way of running a trial.

    Parameters
    ----------
    name
        What it is called in tables.
    where
        ``grid``, or the name of a detector in the simulator.
    altitude_m
        How high the drone flies.
    wind_m_s, gust_m_s
        Mean wind and the standard deviation of its gusts.
    """

    name: str
    where: str
    altitude_m: float
    wind_m_s: float = 0.0
    gust_m_s: float = 0.0


ARMS = (
    Arm("grid, 14 m", "grid", 14.0),
    Arm("rays, 14 m", "rays", 14.0, 2.0, 0.7),
    Arm("camera, 14 m", "camera", 14.0, 2.0, 0.7),
    Arm("grid, 10 m", "grid", 10.0),
    Arm("rays, 10 m", "rays", 10.0),
    Arm("camera, 10 m", "camera", 10.0),
    Arm("rays, 10 m, gusts", "rays", 10.0, 3.0, 3.0),
    Arm("camera, 10 m, gusts", "camera", 10.0, 3.0, 3.0),
)
"""The arms of ``sloop eval fly``, in their order; those of one altitude share starts and places."""


@dataclass(frozen=True)
class FlownTrial:
    """What came of one trial under one arm.

    Parameters
    ----------
    description, target, seed, arm
        Which trial it is.
    map
        Name of the map.
    reachable
        Whether some pose that the planner can reach has the target's cell in view.
    found, steps, discounted_reward
        As of an episode.
    collisions
        How often the drone hit something.
    moves
        Moves forward that were flown.
    in_view, detected
        Looks with the target in the planner's view, and those of them that reported it.
    false_reports
        Looks without the target in view that reported it.
    looks
        Looks in all.
    wrong_finds
        Finds that marked nothing.
    time_s
        Simulated time, seconds; 0 on the grid.
    lost
        Whether the drone was lost.
    """

    description: str
    target: str
    seed: int
    arm: str
    map: str
    reachable: bool
    found: bool
    steps: int
    discounted_reward: float
    collisions: int
    moves: int
    in_view: int
    detected: int
    false_reports: int
    looks: int
    wrong_finds: int
    time_s: float
    lost: bool

    @property
    def key(self) -> tuple[str, str, int, str]:
        """What makes the trial the one it is."""
        return self.description, self.target, self.seed, self.arm


@dataclass(frozen=True)
class FlownTarget:
    """A described target with a seed, which decides where in its cell it stands and all starts.

    Parameters
    ----------
    annotated
        What is said of it.
    target
        Its id.
    seed
        The seed.
    city
        The map.
    """

    annotated: AnnotatedDescription
    target: str
    seed: int
    city: CityMap

    def key(self, arm: Arm) -> tuple[str, str, int, str]:
        """Return the key of its trial under an arm."""
        return self.annotated.id, self.target, self.seed, arm.name

    @property
    def rng(self) -> np.random.Generator:
        """The stream that all of its streams are children of."""
        return child(np.random.default_rng(self.seed), "flown", self.annotated.id, self.target)

    def fault(self) -> str:
        """Return why it cannot be searched for; empty when it can."""
        middle = self.annotated.targets[self.target]
        place = self.place()
        if not self.city.grid.contains(*place):
            return "no room for it on the map"
        off = math.dist(place, (middle.x_m, middle.y_m))
        if off > _MOVED_M:
            return f"the nearest place in the open is {off:.0f} m from the middle of its cell"
        relations = self.annotated.description(self.city).relations
        return "" if any(r.figure == self.target for r in relations) else "nothing is said of it"

    def place(self) -> tuple[float, float]:
        """Return where it stands: in the open, in its annotated cell where there is room."""
        middle = self.annotated.targets[self.target]
        jitter = child(self.rng, "place").uniform(-0.45, 0.45, 2) * self.city.grid.cell_m
        inside = _clamped(self.city, (middle.x_m + jitter[0], middle.y_m + jitter[1]))
        return nearest_free(self.city, inside, _WALL_M)

    def world(self) -> World:
        """Return the world in which it stands there."""
        known = {t.id: t for t in self.annotated.objects}.get(self.target)
        look = look_of(self.target, *((known.kind, known.colour) if known else ()))
        return World.from_map(
            self.city, {self.target: self.place()}, looks={self.target: look}, seed=self.seed
        )


def trials_of(
    flown: FlownTarget, arms: Sequence[Arm], *, sims: int, max_steps: int
) -> list[FlownTrial]:
    """Return what comes of a target under arms of one altitude."""
    from sloop_ppl.inference import infer_description

    target, world, rng = flown.target, flown.world(), flown.rng
    (altitude,) = {a.altitude_m for a in arms}
    description = flown.annotated.description(world.city)
    posterior, _ = infer_description(description, world.city, "bayes")
    share = np.maximum(open_share(world.city), _LEAST_OPEN)
    belief = np.maximum(posterior.belief(target) * share, 1e-15)
    detector = "camera"  # the planner of all arms takes the sensor to be the camera
    config, sensor = flight_plan(
        world.city, SearchConfig(sims=sims, max_steps=max_steps), altitude, detector
    )
    space = SearchSpace.of_city(world.city, (target,), config, sensor=sensor)
    start = start_pose(None, space, child(rng, "start", f"{altitude:g}"))
    reachable = _is_reachable(space, space.snap(start), world.places[target])
    return [
        replace(
            _run(arm, world, space, start, {target: belief}, rng),
            description=flown.annotated.id, target=target, seed=flown.seed,
            map=flown.city.name, reachable=reachable,
        )
        for arm in arms
    ]  # fmt: skip


def _clamped(city: CityMap, place: tuple[float, float]) -> tuple[float, float]:
    west, south, east, north = city.grid.extent_m
    return (
        min(max(place[0], west + 0.5), east - 0.5),
        min(max(place[1], south + 0.5), north - 0.5),
    )


def _is_reachable(space: SearchSpace, pose: int, place: tuple[float, float]) -> bool:
    """Tell whether some pose that can be reached has a place's cell in view."""
    from sloop_ppl.planning._search_tables import likeliest_poses, reach_from

    row, col = space.grid.cell_at(*place)
    reach = reach_from(pose, likeliest_poses(space))
    near = np.flatnonzero(reach.steps >= 0)
    cells = near // 8
    close = (np.abs(cells // space.n_cols - row) <= 4) & (np.abs(cells % space.n_cols - col) <= 4)
    cell = row * space.n_cols + col
    return any(cell in space.view(int(p)) for p in near[close])


def _run(
    arm: Arm,
    world: World,
    space: SearchSpace,
    start: Any,
    beliefs: dict[str, Any],
    rng: np.random.Generator,
) -> FlownTrial:
    (target,) = beliefs
    search_rng = child(rng, "search")
    kwargs: dict[str, Any] = {"config": space.config, "sensor": space.sensor, "rng": search_rng}
    if arm.where == "grid":
        environment = GridEnvironment(
            space, world.places, start, rng=child(rng, "grid environment")
        )
        episode = run_search(beliefs, world.city, world.places, environment=environment, **kwargs)
        log, time_s, collisions, lost = None, 0.0, 0, False
    else:
        drone = Drone(
            world, tuple(start), altitude_m=arm.altitude_m, wind_m_s=arm.wind_m_s,
            gust_m_s=arm.gust_m_s, rng=child(rng, "drone", arm.name),
        )  # fmt: skip
        with Camera(world, drone) as camera:
            flown = MujocoEnvironment(
                world, drone, camera, detector=arm.where, config=space.config,
                sensor=space.sensor,
            )  # fmt: skip
            episode = run_search(beliefs, world.city, world.places, environment=flown, **kwargs)
        log, time_s, collisions = flown.log, drone.time_s, len(flown.log.collisions)
        lost = any("lost" in note for note in episode.notes)
    looked = [i for i, action in enumerate(episode.actions) if not action.startswith("find")]
    seen = [episode.observations[i].get(target) is not None for i in looked]
    cell = world.city.grid.cell_at(*world.places[target])
    if log is None:
        visible = [bool(episode.views[i + 1][cell]) for i in looked]
    else:
        visible = [target in log.in_view[i] for i in looked]
    finds = [i for i, action in enumerate(episode.actions) if action.startswith("find")]
    return FlownTrial(
        description="", target=target, seed=0, arm=arm.name, map="", reachable=True,
        found=episode.found, steps=episode.steps,
        discounted_reward=episode.discounted_return, collisions=collisions,
        moves=sum(a == "forward" for a in episode.actions),
        in_view=sum(visible),
        detected=sum(a and b for a, b in zip(visible, seen, strict=True)),
        false_reports=sum(b and not a for a, b in zip(visible, seen, strict=True)),
        looks=len(looked), wrong_finds=sum(episode.rewards[i] < 0 for i in finds),
        time_s=round(time_s, 2), lost=lost,
    )  # fmt: skip
