"""A request that is refused: its HTTP status and one line of why."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from sloop_ppl.errors import SloopError, on_one_line

__all__ = ["Refusal", "refused", "refused_by_mistake"]


class Refusal(Exception):
    """What a client asked for cannot be had.

    Parameters
    ----------
    status
        HTTP status.
    message
        What was found and what was expected, on one line.
    """

    def __init__(self, status: int, message: str) -> None:
        self.status = status
        super().__init__(message)


async def refused(_request: Request, error: Exception) -> Response:
    """Answer a `Refusal`."""
    status = error.status if isinstance(error, Refusal) else 400
    return JSONResponse({"error": on_one_line(str(error), 500)}, status)


async def refused_by_mistake(_request: Request, error: Exception) -> Response:
    """Answer a user's mistake with its one line."""
    assert isinstance(error, SloopError)
    return JSONResponse({"error": on_one_line(str(error), 1000)}, 422)
