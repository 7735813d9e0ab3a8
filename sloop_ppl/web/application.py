"""The web application: pages, and what they ask for below ``/api``."""

from __future__ import annotations

import asyncio
import contextlib
import json
import secrets
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from sloop_ppl.bridge._catalogue import names_of
from sloop_ppl.errors import NoRelationFound, SloopError
from sloop_ppl.inference import Posterior
from sloop_ppl.web import _limits
from sloop_ppl.web._bodies import body_of, record_of
from sloop_ppl.web._collect_pages import GUEST_PATHS, collect_routes
from sloop_ppl.web._episode_file import read_episode_file
from sloop_ppl.web._examples import first_state
from sloop_ppl.web._exports import export_posterior
from sloop_ppl.web._file_worker import read_dropped_file
from sloop_ppl.web._frame_pages import frame_routes
from sloop_ppl.web._guard import Guard
from sloop_ppl.web._maps import MapShelf, shown_name
from sloop_ppl.web._model_parameters import listed_model, parameters_payload
from sloop_ppl.web._pages import page_routes
from sloop_ppl.web._payloads import belief_payload, frames_payload, reading_payload, why_payload
from sloop_ppl.web._posteriors import Believed, Posteriors, questions_payload
from sloop_ppl.web._refusal import Refusal, refused, refused_by_mistake
from sloop_ppl.web._scene import scene_of
from sloop_ppl.web._search_stream import SearchStreams
from sloop_ppl.web._state import SearchAsked, State, WhyAsked
from sloop_ppl.web._stylesheet import colour_tables
from sloop_ppl.web._workers import warm_workers
from sloop_ppl.web.study import Study

__all__ = ["WebSettings", "application"]

T = TypeVar("T")


@dataclass(frozen=True)
class WebSettings:
    """What a server is started with.

    Parameters
    ----------
    maps
        Names or paths of maps, the one shown first in front.
    host
        Where it is bound.
    token
        The secret that requests have to know; drawn unless given.
    guest_token
        A second secret, for people who describe maps: with it nothing else can be asked.
    folder
        Where annotations and descriptions are kept.
    queue
        Description file whose phrases are annotated; those of a map when None.
    study
        The study of the collection page; one of the bundled maps when None.
    """

    maps: tuple[str, ...] = ()
    host: str = "127.0.0.1"
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24), repr=False)
    guest_token: str = field(default_factory=lambda: secrets.token_urlsafe(24), repr=False)
    folder: Path = Path("sloop-web")
    queue: Path | None = None
    study: Study | None = None


def application(settings: WebSettings) -> Starlette:
    """Return the web application.

    Parameters
    ----------
    settings
        What it is started with.

    Returns
    -------
    starlette.applications.Starlette
        Any ASGI server runs it.

    Raises
    ------
    SloopError
        When a map, the queue or the study cannot be read.
    """
    shelf = MapShelf(settings.maps)
    workbench = _Workbench(shelf)
    routes = [
        *page_routes(),
        *workbench.routes(),
        *frame_routes(shelf, settings.folder / "frames.jsonl", settings.queue),
        *collect_routes(shelf, settings.folder / "descriptions.jsonl", settings.study),
    ]
    handlers: dict[Any, Callable[..., Any]] = {
        Refusal: refused,
        SloopError: refused_by_mistake,
    }
    return Starlette(
        routes=routes,
        exception_handlers=handlers,
        middleware=[
            Middleware(
                Guard,
                token=settings.token,
                host=settings.host,
                guest_token=settings.guest_token,
                guest_paths=GUEST_PATHS,
            )
        ],
        lifespan=_warm,
    )


@contextlib.asynccontextmanager
async def _warm(_app: Starlette) -> AsyncIterator[None]:
    """Load what the first reading, inference and search would else wait for."""

    def first() -> None:
        from sloop_ppl import bridge

        bridge.infer("the green toyota is behind velvet dog", "cleveland").frames("GreenToyota")
        warm_workers()

    task = asyncio.create_task(asyncio.to_thread(first))
    yield
    task.cancel()


class _Workbench:
    """What the workbench page asks for."""

    def __init__(self, shelf: MapShelf) -> None:
        self._shelf = shelf
        self._posteriors = Posteriors(shelf.get)
        self._streams = SearchStreams()

    def routes(self) -> list[Route]:
        """Return the routes below ``/api``."""
        return [
            Route("/api/start", self.start, methods=["GET"]),
            Route("/api/map/{key}", self.map, methods=["GET"]),
            Route("/api/maps", self.take_map, methods=["POST"]),
            Route("/api/episode", self.take_episode, methods=["POST"]),
            Route("/api/parameters/{model}", self.parameters, methods=["GET"]),
            Route("/api/belief", self.belief, methods=["POST"]),
            Route("/api/frames-of", self.frames, methods=["POST"]),
            Route("/api/why", self.why, methods=["POST"]),
            Route("/api/questions", self.questions, methods=["POST"]),
            Route("/api/search", self.search, methods=["POST"]),
            Route("/api/export/{kind}", self.export, methods=["POST"]),
        ]

    async def start(self, _request: Request) -> Response:
        """Return what the page begins with: lists to choose from, colours, an example."""
        return JSONResponse(
            {
                "maps": self._shelf.names(),
                "models": [n for n in names_of("models") if n != "informed"],
                "frames": names_of("frames"),
                "priors": names_of("priors"),
                "planners": names_of("planners"),
                "colours": colour_tables(),
                "first": await _in_thread(lambda: first_state(self._shelf)),
            }
        )

    async def map(self, request: Request) -> Response:
        """Return what is drawn of a map."""
        key = request.path_params["key"]
        text = await _in_thread(lambda: _json(scene_of(self._shelf.get(key), key)))
        return Response(text, media_type="application/json")

    async def take_map(self, request: Request) -> Response:
        """Take in a map file."""
        content = await body_of(request, _limits.MOST_UPLOAD_BYTES)
        name = request.query_params.get("name", "")
        key, note = await _in_thread(lambda: self._shelf.take_in(content, name))
        return JSONResponse({"key": key, "note": note, "maps": self._shelf.names()})

    async def take_episode(self, request: Request) -> Response:
        """Take in an episode, and return it as the page plays it."""
        content = await body_of(request, _limits.MOST_EPISODE_BYTES)
        name = shown_name(request.query_params.get("name", ""), "dropped episode")
        text = await _in_thread(lambda: _json(self._played(content, name)))
        return Response(text, media_type="application/json")

    def _played(self, content: bytes, name: str) -> dict[str, Any]:
        read = read_dropped_file(read_episode_file, content, name, "Episode")
        key = self._shelf.key_of_episode(read["map"], read.pop("map_digest"))
        shape = read.pop("shape")
        if shape and tuple(shape) != self._shelf.get(key).grid.shape:
            raise Refusal(
                422,
                f"Episode '{name}' is of {shape[0]} x {shape[1]} cells, map '{read['map']}' is "
                "not; open the map it was searched on first",
            )
        known = read["model"] in names_of("models")
        return {**read, "map": key, "model": read["model"] if known else "bayes"}

    async def parameters(self, request: Request) -> Response:
        """Return the numbers of a model that a page may change."""
        name, variant = request.path_params["model"], request.query_params.get("variant", "")
        found = await _in_thread(
            lambda: parameters_payload(listed_model(name, variant or "published"))
        )
        return JSONResponse({"parameters": found})

    async def belief(self, request: Request) -> Response:
        """Return what was read and what is believed."""
        state = await record_of(request, State)
        return Response(
            await _in_thread(lambda: _json(self._believed(state))), media_type="application/json"
        )

    def _believed(self, state: State) -> dict[str, Any]:
        city = self._shelf.get(state.map)
        if not state.text.strip():
            return {"reading": None, "belief": None, "problem": ""}
        believed: Believed = self._posteriors.of(state)
        posterior = believed.posterior
        return {
            "reading": reading_payload(believed.read, city),
            "belief": None if posterior is None else belief_payload(posterior),
            "problem": believed.problem,
        }

    async def frames(self, request: Request) -> Response:
        """Return which way the grounds face."""
        state = await record_of(request, State)
        return JSONResponse(await _in_thread(lambda: frames_payload(self._posterior(state))))

    async def why(self, request: Request) -> Response:
        """Return how much each phrase moves the belief, and what each says of a place."""
        asked = await record_of(request, WhyAsked)
        return JSONResponse(
            await _in_thread(
                lambda: why_payload(self._posterior(asked.state), asked.target, asked.at)
            )
        )

    async def questions(self, request: Request) -> Response:
        """Return the questions worth asking."""
        state = await record_of(request, State)
        return JSONResponse(
            {"questions": await _in_thread(lambda: questions_payload(self._posterior(state)))}
        )

    async def search(self, request: Request) -> Response:
        """Search, and send each step when it is done."""
        asked = await record_of(request, SearchAsked)
        if asked.planner not in names_of("planners"):
            raise Refusal(422, f"Planner '{asked.planner}' is unknown")
        posterior = await _in_thread(lambda: self._posterior(asked.state))
        self._streams.take_place()
        return StreamingResponse(
            self._streams.events(posterior, asked), media_type="text/event-stream"
        )

    async def export(self, request: Request) -> Response:
        """Return the posterior as a file."""
        state = await record_of(request, State)
        kind = request.path_params["kind"]
        content, media, name = await _in_thread(
            lambda: export_posterior(self._posterior(state), kind)
        )
        disposition = f'attachment; filename="{name}"'
        return Response(content, media_type=media, headers={"content-disposition": disposition})

    def _posterior(self, state: State) -> Posterior:
        believed = self._posteriors.of(state)
        if believed.posterior is None:
            raise NoRelationFound(believed.problem)
        return believed.posterior


async def _in_thread(work: Callable[[], T]) -> T:
    return await asyncio.to_thread(work)


def _json(payload: dict[str, Any]) -> bytes:
    return json.dumps(payload, ensure_ascii=False, allow_nan=False).encode()
