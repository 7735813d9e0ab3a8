"""Carry out what ``sloop fly`` asks for: a search whose moves are flown in the simulator."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from sloop_ppl.bridge._search_request import (
    SearchRequest,
    SearchResult,
    Staged,
    prepared,
    run_request,
)
from sloop_ppl.bridge._timed_utterances import descriptions_of, read_utterances
from sloop_ppl.bridge.searching import Places, imagined_places
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference import Posterior
from sloop_ppl.planning import SearchConfig, SearchSpace, Step
from sloop_ppl.planning.environment import start_pose
from sloop_ppl.rng import child
from sloop_ppl.simulation import (
    DETECTORS,
    Camera,
    Detection,
    Drone,
    Film,
    Look,
    MujocoEnvironment,
    ServedDrone,
    World,
    check_film_path,
    flight_plan,
    look_of,
    nearest_free,
    open_share,
    serve,
)

__all__ = ["FlyRequest", "in_the_open", "looks_of", "run_fly_request", "serve_flight"]

_LEAST_OPEN = 0.02


@dataclass(frozen=True)
class FlyRequest:
    """What ``sloop fly`` asks for beside the search; see its options."""

    search: SearchRequest
    altitude_m: float = 14.0
    wind_m_s: float = 2.0
    detector: str = "camera"
    video: Path | None = None
    battery_steps: int | None = None
    mjcf: Path | None = None


def run_fly_request(request: FlyRequest, notify: Callable[[str], None]) -> SearchResult:
    """Infer, fly and write what was asked for.

    Raises
    ------
    SloopError
        For any mistake in the request, before anything is flown.
    SearchInterrupted
        On Ctrl-C, once what was done until then has been written.
    """
    if request.detector not in DETECTORS:
        raise UnknownName("detector", request.detector, DETECTORS)
    if request.video:
        check_film_path(request.video)
    with ExitStack() as stack:
        staging = _Staging(request, notify, stack)
        result = run_request(_with_beliefs(request), notify, stage=staging)
        if staging.film is not None and request.video:
            staging.film.write(request.video, result.episode)
        text = " ".join(result.posterior.texts)
        return replace(result, report={**result.report, "text": text, **staging.report()})


def serve_flight(request: FlyRequest, port: int, notify: Callable[[str], None]) -> None:
    """Put the targets of a sentence into the simulator and let AirSim's clients fly the drone.

    Parameters
    ----------
    request
        What is flown; of the search only what is inferred, the places and the start count.
    port
        Where it is served, on this machine alone; 0 takes a free one.

    Raises
    ------
    SloopError
        For any mistake in the request, or when the port cannot be had.
    """
    posterior, places, config, start = prepared(request.search, notify)
    with ExitStack() as stack:
        staging = _Staging(request, notify, stack)
        camera = staging.parked(posterior, places, config, start)
        for name, (x, y) in staging.places.items():
            notify(f"{name} stands at ({x:.1f}, {y:.1f})")
        serve(
            ServedDrone(camera),
            port,
            ready=lambda server: notify(
                f"AirSim's calls are answered at 127.0.0.1:{server.port}; Ctrl-C ends it"
            ),
        )


def looks_of(posterior: Posterior) -> dict[str, Look]:
    """Return what the targets of a posterior look like, as far as it was declared."""
    declared = {t.id: t for d in posterior.descriptions for t in d.targets}
    looks = {}
    for name in posterior.targets:
        known = declared.get(name)
        looks[name] = look_of(name) if known is None else look_of(name, known.kind, known.colour)
    return looks


def in_the_open(posterior: Posterior) -> Posterior:
    """Return the posterior that knows that targets stand in the open.

    Notes
    -----
    A cell counts by the share of it that no building covers, at least `_LEAST_OPEN`: what language
    says of a building is not always about its outside.
    """
    share = np.log(np.maximum(open_share(posterior.city), _LEAST_OPEN))
    return posterior.condition(dict.fromkeys(posterior.targets, share))


def _with_beliefs(request: FlyRequest) -> SearchRequest:
    if request.search.sensor is not None:
        raise InputError("The drone senses with --detector; leave --sensor out")
    keep = request.search.keep_beliefs or request.video is not None
    return replace(request.search, keep_beliefs=keep)


class _Staging:
    """Makes world, drone and camera once the posterior is known."""

    def __init__(
        self, request: FlyRequest, notify: Callable[[str], None], stack: ExitStack
    ) -> None:
        self._request, self._notify, self._stack = request, notify, stack
        self.film: Film | None = None
        self.places: dict[str, tuple[float, float]] = {}
        self._environment: MujocoEnvironment | None = None
        self._seen: tuple[Detection, ...] = ()

    def __call__(
        self,
        posterior: Posterior,
        places: Places,
        config: SearchConfig,
        start: tuple[float, ...] | None,
    ) -> Staged:
        request, rng = self._request, np.random.default_rng(self._request.search.seed)
        world, imagined = self._world(posterior, places, rng)
        posterior = in_the_open(replace(posterior, city=world.city))
        config, sensor = flight_plan(world.city, config, request.altitude_m, request.detector)
        space = SearchSpace.of_city(world.city, posterior.targets, config, sensor=sensor)
        camera = self._camera(world, space, posterior, start, request.altitude_m, rng)
        environment = MujocoEnvironment(
            world, camera.drone, camera, detector=request.detector, config=config, sensor=sensor
        )
        if environment.detector.needs_pictures or request.video:
            camera.picture()  # says at once when no pictures can be made here
        self._environment = environment
        if request.video:
            self.film = Film(camera)
        return Staged(posterior, environment, config, self.places, imagined, sensor, self._on_step)

    def parked(
        self,
        posterior: Posterior,
        places: Places,
        config: SearchConfig,
        start: tuple[float, ...] | None,
    ) -> Camera:
        """Return the camera of a drone that waits on the ground."""
        rng = np.random.default_rng(self._request.search.seed)
        world, _ = self._world(posterior, places, rng)
        on_ground = replace(config, no_fly=True, flight_height_m=0.1)
        space = SearchSpace.of_city(world.city, posterior.targets, on_ground)
        return self._camera(world, space, posterior, start, 0.0, rng)

    def _world(
        self, posterior: Posterior, places: Places, rng: np.random.Generator
    ) -> tuple[World, tuple[str, ...]]:
        """Build the world; return it with the names of the targets whose places were drawn."""
        if not posterior.city.of_kind("building"):
            self._notify("note: the map has no buildings; nothing closes flight or sight")
        imagined = self._imagined(posterior, places, rng)
        self.places = {t: {**places, **imagined}[t] for t in posterior.targets}
        world = World.from_map(
            posterior.city, self.places, looks=looks_of(posterior), seed=self._request.search.seed
        )
        if self._request.mjcf:
            world.to_mjcf(self._request.mjcf)
        return world, tuple(imagined)

    def _camera(
        self,
        world: World,
        space: SearchSpace,
        posterior: Posterior,
        start: tuple[float, ...] | None,
        altitude_m: float,
        rng: np.random.Generator,
    ) -> Camera:
        """Return the camera of a drone at the start."""
        request = self._request
        area = None if posterior.area is None else posterior.area.cells
        pose = start_pose(start, space, rng, area)
        drone = Drone(
            world, (pose.x_m, pose.y_m, pose.heading_rad), altitude_m=altitude_m,
            wind_m_s=request.wind_m_s, battery_steps=request.battery_steps,
            rng=child(rng, "environment"),
        )  # fmt: skip
        return self._stack.enter_context(Camera(world, drone))

    def report(self) -> dict[str, object]:
        """Return what ``sloop fly --json`` has beside the keys of a search."""
        environment = self._environment
        if environment is None:
            return {}
        log = environment.log
        return {
            "collisions": [{"step": step, "with": name} for step, name in log.collisions],
            "detections": [
                [
                    {
                        "target": d.target,
                        "place": [round(v, 3) for v in d.place],
                        "share": round(d.share, 3),
                    }
                    for d in seen
                ]
                for seen in log.detections
            ],
            "time_s": round(environment.drone.time_s, 2),
            "altitude_m": self._request.altitude_m,
            "wind_m_s": self._request.wind_m_s,
            "detector": self._request.detector,
        }

    def _imagined(
        self, posterior: Posterior, places: Places, rng: np.random.Generator
    ) -> dict[str, tuple[float, float]]:
        """Draw the places that are not given, in the open, given all that will be said."""
        informed = posterior
        typed = read_utterances(self._request.search.utterances)
        for step, description in descriptions_of(posterior, typed).items():
            informed = informed.update(description, rng=child(rng, "said", step))
        drawn = imagined_places(informed, places, rng=rng, targets=posterior.targets)
        open_air = {}
        for name, place in drawn.items():
            free = nearest_free(posterior.city, place)
            if math.dist(free, place) > 0:
                self._notify(
                    f"note: {name} was imagined inside a building and stands beside it, at "
                    f"({free[0]:.1f}, {free[1]:.1f})"
                )
            open_air[name] = free
        return open_air

    def _on_step(self, step: Step) -> None:
        environment = self._environment
        if environment is None:
            return
        log = environment.log
        if log.detections and not step.action.startswith("find"):
            self._seen = log.detections[-1]  # a find goes by the look before it
        if self.film is not None:
            self.film.look(self._seen)
        if step.collision and log.collisions:
            self._notify(f"     hit {log.collisions[-1][1]} and went back")
