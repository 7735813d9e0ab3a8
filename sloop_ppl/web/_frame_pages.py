"""What the page on frames of reference asks for: a queue of phrases, and to save annotations."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path
from typing import Annotated, Any

from msgspec import Meta, Struct
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from sloop_ppl._journal import Journal
from sloop_ppl.web._bodies import record_of
from sloop_ppl.web._frame_queue import FrameItem, items_of_file, items_of_map
from sloop_ppl.web._maps import MapShelf
from sloop_ppl.web._refusal import Refusal
from sloop_ppl.web._state import Name, Place

__all__ = ["FrameJudged", "frame_routes"]

_LEAST_M = 0.5


class FrameJudged(Struct, frozen=True, forbid_unknown_fields=True):
    """What an annotator says of one phrase.

    Parameters
    ----------
    item
        Name of the phrase in its queue.
    annotator
        Who says so.
    map
        Key of the map whose queue it is; of a queue of a file None.
    origin
        Where the front vector begins, metres.
    end
        Where it ends; None when the frame is unclear.
    seconds
        How long it took.
    """

    item: Name
    annotator: Annotated[
        str, Meta(min_length=1, max_length=60, pattern=r"\S", description="a name")
    ]
    map: Name | None = None
    origin: Place | None = None
    end: Place | None = None
    seconds: Annotated[float, Meta(ge=0, le=1e6, description="seconds")] = 0.0


def frame_routes(shelf: MapShelf, path: Path, queue: Path | None) -> list[Route]:
    """Return the routes below ``/api/frames``.

    Parameters
    ----------
    shelf
        The maps.
    path
        Where annotations are saved.
    queue
        Description file whose phrases are annotated; those of a map when None.

    Raises
    ------
    SloopError
        When the file cannot be used.
    """
    pages = _FramePages(shelf, Journal(path), None if queue is None else items_of_file(queue))
    return [
        Route("/api/frames/queue", pages.queue, methods=["GET"]),
        Route("/api/frames/annotations", pages.save, methods=["POST"]),
    ]


class _FramePages:
    def __init__(self, shelf: MapShelf, journal: Journal, items: list[FrameItem] | None) -> None:
        self._shelf, self._journal, self._items = shelf, journal, items
        if items is not None:
            for source in dict.fromkeys(item.map for item in items):
                shelf.add(source)

    async def queue(self, request: Request) -> Response:
        """Return the phrases, and which of them an annotator has done."""
        key = request.query_params.get("map", self._shelf.first)
        annotator = request.query_params.get("annotator", "")
        return JSONResponse(await asyncio.to_thread(self._queue, key, annotator))

    def _queue(self, key: str, annotator: str) -> dict[str, Any]:
        items = self._items_for(key)
        done = {}
        for record in self._journal.records():
            if record.get("annotator") == annotator:
                done[record["item"]] = {
                    "unclear": "unclear" in record,
                    "origin": record.get("origin_m"),
                    "end": record.get("end_m"),
                }
        return {
            "file": self._journal.shown,
            "own_queue": self._items is not None,
            "maps": self._shelf.names(),
            "map": key,
            "items": [
                {
                    "id": item.id,
                    "map": self._shelf.key_of(item.map),
                    "text": item.text,
                    "ground": item.ground,
                    "relation": item.relation,
                }
                for item in items
            ],
            "done": done,
        }

    def _items_for(self, key: str | None) -> list[FrameItem]:
        if self._items is not None:
            return self._items
        city = self._shelf.get(key or self._shelf.first)
        source = self._shelf.sources.get(key or self._shelf.first)
        if source is None:
            raise Refusal(
                422,
                "Annotations name their map, and this one is in no file; start the server with "
                "--map FILE",
            )
        return items_of_map(city, source)

    async def save(self, request: Request) -> Response:
        """Save one annotation, on the disk before it is answered."""
        judged = await record_of(request, FrameJudged)
        return JSONResponse(await asyncio.to_thread(self._save, judged))

    def _save(self, judged: FrameJudged) -> dict[str, Any]:
        found = [item for item in self._items_for(judged.map) if item.id == judged.item]
        if not found:
            raise Refusal(404, "This phrase is not in the queue")
        item, annotator = found[0], " ".join(judged.annotator.split())
        before = self._journal.records()
        count = sum(r.get("item") == item.id and r.get("annotator") == annotator for r in before)
        about = {"ground": item.ground, "relation": item.relation}
        record: dict[str, Any] = {
            "id": f"{item.id}@{annotator}" + (f"#{count + 1}" if count else ""),
            "map": item.map,
            "text": item.text,
            "frames": [],
            "item": item.id,
            "annotator": annotator,
            "seconds": round(judged.seconds, 1),
        }
        front_deg = None
        if judged.end is None or judged.origin is None:
            record["unclear"] = {**about, "annotator": annotator}
        else:
            (x0, y0), (x1, y1) = judged.origin, judged.end
            if math.hypot(x1 - x0, y1 - y0) < _LEAST_M:
                raise Refusal(422, "The arrow has no length; its end goes elsewhere")
            front_deg = round(math.degrees(math.atan2(y1 - y0, x1 - x0)), 2)
            record["frames"] = [{**about, "front_deg": front_deg, "annotator": annotator}]
            record["origin_m"], record["end_m"] = list(judged.origin), list(judged.end)
        self._journal.append(record)
        return {"id": record["id"], "front_deg": front_deg}
