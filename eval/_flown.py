"""Searches of the same targets on the grid, with rays, and with the camera in the simulator."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from sloop_ppl._journal import Journal
from sloop_ppl._records import Fault, checked
from sloop_ppl.errors import InputError
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.maps import CityMap
from sloop_ppl.outputs import check_output_folder
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
    open_share,
)
from sloop_ppl.simulation.world import nearest_free

__all__ = ["ARMS", "Arm", "FlownTrial", "fly_trials", "read_flown"]

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


def fly_trials(
    descriptions: Sequence[AnnotatedDescription],
    find_map: Callable[[str], CityMap],
    out: Path,
    *,
    targets: int = 40,
    seeds: int = 2,
    arms: Sequence[Arm] = ARMS,
    sims: int = 500,
    max_steps: int = 120,
    notify: Callable[[str], None],
) -> list[FlownTrial]:
    """Run trials, or go on with those that a stopped run has left.

    Parameters
    ----------
    descriptions
        Described targets, with gold relations.
    find_map
        Name of a map -> the map.
    out
        Folder of the run; trials are written there as they are done.
    targets
        How many of the described targets are searched for, at most.
    seeds
        How often each, with other starts and other places within the cell.
    arms
        What each is run with.
    sims, max_steps
        Of each search.
    notify
        Called with a line of progress after each trial.
    """
    folder = check_output_folder(out)
    path = folder / "trials.jsonl"
    journal, done = Journal(path), {t.key: t for t in read_flown(path)}
    chosen = _interleaved(descriptions)[:targets]
    for seed in range(seeds):
        for annotated, target in chosen:
            missing = [a for a in arms if (annotated.id, target, seed, a.name) not in done]
            if not missing:
                continue
            for trial in _trials_of(
                annotated, target, seed, find_map(annotated.map), missing, sims, max_steps
            ):
                done[trial.key] = trial
                journal.append(asdict(trial))
                notify(
                    f"{len(done)}: {trial.description} {trial.target} seed {seed}, {trial.arm}: "
                    f"{'found' if trial.found else 'not found'}, {trial.steps} steps"
                )
    return [done[key] for key in sorted(done)]


def read_flown(path: Path) -> list[FlownTrial]:
    """Return the trials of a file; none when there is no file.

    Raises
    ------
    InputError
        When a line is no trial.
    """
    trials = []
    for number, record in enumerate(Journal(path).records(), 1):
        try:
            trials.append(checked(record, FlownTrial))
        except Fault as fault:
            raise InputError(
                f"Trial {number} of '{path}' is no flown trial: {fault}; delete its line, and give "
                "the same command again to fly it anew"
            ) from None
    return trials


def _interleaved(
    descriptions: Sequence[AnnotatedDescription],
) -> list[tuple[AnnotatedDescription, str]]:
    """Return the targets, those of all maps in turn, so that a part of them speaks of each."""
    by_map: dict[str, list[tuple[AnnotatedDescription, str]]] = {}
    for annotated in descriptions:
        for target in annotated.targets:
            by_map.setdefault(annotated.map, []).append((annotated, target))
    longest = max((len(v) for v in by_map.values()), default=0)
    return [v[i] for i in range(longest) for v in by_map.values() if i < len(v)]


def _trials_of(
    annotated: AnnotatedDescription,
    target: str,
    seed: int,
    city: CityMap,
    arms: Sequence[Arm],
    sims: int,
    max_steps: int,
) -> Iterator[FlownTrial]:
    """Yield what comes of one target and seed under each arm; nothing where it has no room."""
    from sloop_ppl.inference import infer_description

    rng = np.random.default_rng(seed)
    rng = child(rng, "flown", annotated.id, target)
    place = annotated.targets[target]
    jitter = child(rng, "place").uniform(-0.45, 0.45, 2) * city.grid.cell_m
    inside = _clamped(city, (place.x_m + jitter[0], place.y_m + jitter[1]))
    free = nearest_free(city, inside, _WALL_M)
    if math.dist(free, (place.x_m, place.y_m)) > _MOVED_M or not city.grid.contains(*free):
        return
    objects = {t.id: t for t in annotated.objects}
    known = objects.get(target)
    look = look_of(target) if known is None else look_of(target, known.kind, known.colour)
    world = World.from_map(city, {target: free}, looks={target: look}, seed=seed)
    description = annotated.description(world.city)
    if not any(r.figure == target for r in description.relations):
        return
    posterior, _ = infer_description(description, world.city, "bayes")
    share = np.maximum(open_share(world.city), _LEAST_OPEN)
    belief = np.maximum(posterior.belief(target) * share, 1e-15)
    for altitude in sorted({a.altitude_m for a in arms}, reverse=True):
        same = [a for a in arms if a.altitude_m == altitude]
        detector = "camera"  # the planner of all arms takes the sensor to be the camera
        config, sensor = flight_plan(
            world.city, SearchConfig(sims=sims, max_steps=max_steps), altitude, detector
        )
        space = SearchSpace.of_city(world.city, (target,), config, sensor=sensor)
        start = start_pose(None, space, rng)
        reachable = _is_reachable(space, space.snap(start), free)
        for arm in same:
            yield replace(
                _run(arm, world, space, start, {target: belief}, rng),
                description=annotated.id, target=target, seed=seed, map=city.name,
                reachable=reachable,
            )  # fmt: skip


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
