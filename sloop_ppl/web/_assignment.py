"""Who describes what: each configuration by a few people, nobody the same one twice."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Mapping
from typing import Any

from sloop_ppl.web.study import Configuration, Study

__all__ = ["Assignment", "speakers_of"]

_HELD_S = 30 * 60.0


class Assignment:
    """Gives people configurations, and holds each for who got it for half an hour.

    Parameters
    ----------
    study
        The study.
    clock
        Seconds that never go back.
    """

    def __init__(self, study: Study, clock: Callable[[], float] = time.monotonic) -> None:
        self._study, self._clock = study, clock
        self._held: dict[str, tuple[str, float]] = {}

    def next_for(self, person: str, records: list[dict[str, Any]]) -> Configuration | None:
        """Return what a person describes next: one described least so far, by lot among equals.

        Parameters
        ----------
        person
            Who asks; asking again before answering gives the same one.
        records
            The lines saved so far, answers and skips.

        Returns
        -------
        Configuration or None
            None when nothing is left for this person.
        """
        speakers = speakers_of(records)
        now = self._clock()
        self._held = {p: h for p, h in self._held.items() if h[1] > now}
        seen = {r.get("configuration") for r in records if r.get("speaker") == person}
        held = self._held.get(person)
        counts = {
            one.id: len(
                speakers.get(one.id, set())
                | {p for p, (c, _) in self._held.items() if c == one.id and p != person}
            )
            for one in self._study.configurations
        }
        left = [
            one
            for one in self._study.configurations
            if one.id not in seen and counts[one.id] < self._study.people
        ]
        if not left:
            return None
        kept = [one for one in left if held is not None and held[0] == one.id]
        chosen = kept[0] if kept else min(left, key=lambda one: (counts[one.id], _lot(person, one)))
        self._held[person] = (chosen.id, now + _HELD_S)
        return chosen

    def release(self, person: str) -> None:
        """Forget what a person holds, who has answered or skipped it."""
        self._held.pop(person, None)


def _lot(person: str, one: Configuration) -> bytes:
    """Return what puts equals in another order for each person, the same on every run."""
    return hashlib.sha256(f"{person}/{one.id}".encode()).digest()


def speakers_of(records: list[dict[str, Any]]) -> Mapping[str, set[str]]:
    """Return who has described each configuration."""
    found: dict[str, set[str]] = {}
    for record in records:
        if "text" in record:
            found.setdefault(record["configuration"], set()).add(record["speaker"])
    return found
