"""What the collection page and the page of progress ask for."""

from __future__ import annotations

import asyncio
import re
import secrets
import threading
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from msgspec import Meta, Struct
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from sloop_ppl._journal import Journal
from sloop_ppl.bridge.relation_text import relation_in_words
from sloop_ppl.eval._line_format import EntryLine
from sloop_ppl.eval._objects import declared_object
from sloop_ppl.language import RELATIONS, Description, TargetObject, parse
from sloop_ppl.language._place_names import PlaceNames
from sloop_ppl.maps import bundled_maps
from sloop_ppl.web import _limits
from sloop_ppl.web._assignment import Assignment, speakers_of
from sloop_ppl.web._bodies import record_of
from sloop_ppl.web._maps import MapShelf
from sloop_ppl.web._refusal import Refusal
from sloop_ppl.web._state import Name
from sloop_ppl.web.study import Configuration, Study, merged_answers, prepare_study

__all__ = ["GUEST_PATHS", "collect_routes"]

GUEST_PATHS = ("/api/collect/guest/", "/api/map/")
"""What who was invited to describe may ask for; the rest is of who runs the study."""

Person = Annotated[str, Meta(pattern=r"^[A-Za-z0-9_-]{8,40}$", description="a participant's id")]
Text = Annotated[str, Meta(max_length=_limits.MOST_TEXT, pattern=r"\S", description="a text")]


class Asking(Struct, frozen=True, forbid_unknown_fields=True):
    """A participant wants the next configuration, having passed over one perhaps."""

    person: Person
    skipped: Name | None = None


class Read(Struct, frozen=True, forbid_unknown_fields=True):
    """A text so far, to be read."""

    configuration: Name
    text: Annotated[str, Meta(max_length=_limits.MOST_TEXT)]


class Described(Struct, frozen=True, forbid_unknown_fields=True):
    """One or two descriptions of a configuration."""

    person: Person
    configuration: Name
    texts: Annotated[tuple[Text, ...], Meta(min_length=1, max_length=2)]
    consent: bool


class Correction(Struct, frozen=True, forbid_unknown_fields=True):
    """What a description truly says."""

    id: Name
    relations: Annotated[list[EntryLine], Meta(max_length=50)]


def collect_routes(shelf: MapShelf, path: Path, study: Study | None) -> list[Route]:
    """Return the routes below ``/api/collect``.

    Parameters
    ----------
    shelf
        The maps.
    path
        Where descriptions are saved.
    study
        The study; one of the bundled maps when None.
    """
    if study is None:
        study = prepare_study(bundled_maps(), 4, 5, rng=np.random.default_rng(0))
    pages = _CollectPages(shelf, Journal(path), study)
    return [
        Route("/api/collect/guest/join", pages.join, methods=["POST"]),
        Route("/api/collect/guest/next", pages.next, methods=["POST"]),
        Route("/api/collect/guest/read", pages.read, methods=["POST"]),
        Route("/api/collect/guest/descriptions", pages.save, methods=["POST"]),
        Route("/api/collect/progress", pages.progress, methods=["GET"]),
        Route("/api/collect/corrections", pages.correct, methods=["POST"]),
    ]


class _CollectPages:
    def __init__(self, shelf: MapShelf, journal: Journal, study: Study) -> None:
        self._shelf, self._journal, self._study = shelf, journal, study
        self._assignment = Assignment(study)
        self._lock = threading.Lock()
        for source in dict.fromkeys(one.map for one in study.configurations):
            shelf.add(source)

    async def join(self, _request: Request) -> Response:
        """Return a new participant's id, which says nothing of who it is."""
        return JSONResponse({"person": secrets.token_urlsafe(9)})

    async def next(self, request: Request) -> Response:
        """Return the next configuration, or that nothing is left."""
        asking = await record_of(request, Asking)
        return JSONResponse(await asyncio.to_thread(self._next, asking))

    def _next(self, asking: Asking) -> dict[str, Any]:
        with self._lock:
            if asking.skipped is not None:
                self._find(asking.skipped)
                self._journal.append({"configuration": asking.skipped, "speaker": asking.person})
                self._assignment.release(asking.person)
            records = self._journal.records()
            found = self._assignment.next_for(asking.person, records)
        own = {
            r["configuration"] for r in records if r.get("speaker") == asking.person and "text" in r
        }
        if found is None:
            return {"configuration": None, "described": len(own)}
        return {
            "configuration": found.id,
            "map": self._shelf.key_of(found.map),
            "objects": [
                {"id": name, "at": list(at), "name": _spoken_name(name)}
                for name, at in found.targets.items()
            ],
            "described": len(own),
        }

    async def read(self, request: Request) -> Response:
        """Return what was read of a text so far, as a hint."""
        asked = await record_of(request, Read)
        return JSONResponse(await asyncio.to_thread(self._hint, asked))

    def _hint(self, asked: Read) -> dict[str, Any]:
        one = self._find(asked.configuration)
        read = self._parsed(one, asked.text)
        city = self._shelf.get(self._shelf.key_of(one.map))
        names = PlaceNames(city, (read,))
        placed = {relation.figure for relation in read.relations}
        return {
            "phrases": [
                f"{_spoken_name(r.figure)} {relation_in_words(r, names)}" for r in read.relations
            ],
            "missing": [_spoken_name(name) for name in one.targets if name not in placed],
        }

    async def save(self, request: Request) -> Response:
        """Save what a participant said, on the disk before it is answered."""
        given = await record_of(request, Described)
        return JSONResponse(await asyncio.to_thread(self._save, given))

    def _save(self, given: Described) -> dict[str, Any]:
        if not given.consent:
            raise Refusal(422, "Nothing is saved without consent")
        one = self._find(given.configuration)
        with self._lock:
            records = self._journal.records()
            if given.person in speakers_of(records).get(one.id, ()):
                raise Refusal(409, "You have described this map already; go on to the next")
            number = sum("text" in r and r["configuration"] == one.id for r in records)
            for offset, text in enumerate(given.texts, start=1):
                read = self._parsed(one, text)
                self._journal.append(
                    {
                        "id": f"{one.id}-{number + offset}",
                        "map": one.map,
                        "configuration": one.id,
                        "speaker": given.person,
                        "text": " ".join(text.split()),
                        "targets": {
                            name: {"east_m": x, "north_m": y}
                            for name, (x, y) in one.targets.items()
                        },
                        "relations": _entries(read),
                        "checked": False,
                        "consent": True,
                    }
                )
            self._assignment.release(given.person)
        return {"saved": len(given.texts)}

    async def progress(self, _request: Request) -> Response:
        """Return how far the study is, and what was said."""
        return JSONResponse(await asyncio.to_thread(self._progress))

    def _progress(self) -> dict[str, Any]:
        records = self._journal.records()
        speakers = speakers_of(records)
        return {
            "file": self._journal.shown,
            "people": self._study.people,
            "configurations": [
                {"id": one.id, "map": one.map, "people": len(speakers.get(one.id, ()))}
                for one in self._study.configurations
            ],
            "words": sorted(RELATIONS),
            "grounds": {
                one.map: [
                    {"id": m.id, "label": m.label}
                    for m in self._shelf.get(self._shelf.key_of(one.map)).landmarks
                ]
                for one in {c.map: c for c in self._study.configurations}.values()
            },
            "answers": merged_answers(records),
        }

    async def correct(self, request: Request) -> Response:
        """Save what a description truly says."""
        correction = await record_of(request, Correction)
        return JSONResponse(await asyncio.to_thread(self._correct, correction))

    def _correct(self, correction: Correction) -> dict[str, Any]:
        with self._lock:
            known = {one["id"]: one for one in merged_answers(self._journal.records())}
            if correction.id not in known:
                raise Refusal(404, "There is no such description")
            line = known[correction.id]
            city = self._shelf.get(self._shelf.key_of(line["map"]))
            for entry in correction.relations:
                if entry.relation not in RELATIONS:
                    raise Refusal(422, f"'{entry.relation[:40]}' is no relation")
                if entry.ground is None or entry.ground not in city:
                    raise Refusal(422, f"'{(entry.ground or '')[:40]}' is not on the map")
                if entry.figure not in line["targets"]:
                    raise Refusal(422, f"'{entry.figure[:40]}' is no object of this description")
            self._journal.append(
                {
                    "correction_of": correction.id,
                    "relations": [
                        {
                            "figure": e.figure,
                            "relation": e.relation,
                            "ground": e.ground,
                            **({"negated": True} if e.negated else {}),
                            **({} if e.group is None else {"group": e.group}),
                        }
                        for e in correction.relations
                    ],
                }
            )
        return {"checked": True}

    def _find(self, name: str) -> Configuration:
        for one in self._study.configurations:
            if one.id == name:
                return one
        raise Refusal(404, "There is no such configuration")

    def _parsed(self, one: Configuration, text: str) -> Description:
        city = self._shelf.get(self._shelf.key_of(one.map))
        return parse(" ".join(text.split()), city, targets=_objects(one))


def _objects(one: Configuration) -> list[TargetObject]:
    return [declared_object(name) for name in one.targets]


def _spoken_name(name: str) -> str:
    """Return an object's id as words: "the green Toyota"."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).split()
    return " ".join(
        [
            "the",
            words[0].lower(),
            *(w if w in ("Toyota", "Honda") else w.lower() for w in words[1:]),
        ]
    )


def _entries(read: Description) -> list[dict[str, Any]]:
    """Return the relations as description files have them; what is on no map is left out."""
    kept = ("figure", "relation", "ground", "group", "distance_m", "either")
    return [
        {name: entry[name] for name in kept if entry[name] is not None}
        | ({"negated": True} if entry["negated"] else {})
        for entry in read.to_json()["relations"]
        if entry["ground"] is not None and entry["figure"] in {t.id for t in read.targets}
    ]
