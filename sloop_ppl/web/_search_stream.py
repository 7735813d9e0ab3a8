"""Searches as server-sent events, each in a process that ends when the page leaves."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

from sloop_ppl.inference import Posterior
from sloop_ppl.web import _limits
from sloop_ppl.web._refusal import Refusal
from sloop_ppl.web._search_worker import search_in_worker
from sloop_ppl.web._state import SearchAsked
from sloop_ppl.web._workers import Worker

__all__ = ["SearchStreams"]

_POLL_S = 0.25


class SearchStreams:
    """The searches that run at present; of more than a few at a time one is refused."""

    def __init__(self) -> None:
        self.running = 0

    def take_place(self) -> None:
        """Count one more search.

        Raises
        ------
        Refusal
            When there are too many.
        """
        if self.running >= _limits.MOST_STREAMS:
            raise Refusal(
                429, f"{self.running} searches run at present; wait until one of them has ended"
            )
        self.running += 1

    async def events(self, posterior: Posterior, asked: SearchAsked) -> AsyncIterator[bytes]:
        """Yield the events of a search; `take_place` comes before, and is undone at the end.

        Closing it, which happens when the page leaves, ends the process.
        """
        worker = None
        try:
            worker = await asyncio.to_thread(Worker, search_in_worker, posterior, asked)
            while True:
                message = await asyncio.to_thread(worker.receive, _POLL_S)
                if message is not None:
                    yield b"data: " + message + b"\n\n"
                elif not worker.may_send:
                    break
        finally:
            self.running -= 1
            if worker is not None:
                worker.stop()
