"""Read the body of a request: of bounded size, within bounded time, against a record."""

from __future__ import annotations

import asyncio
from typing import TypeVar

from starlette.requests import Request

from sloop_ppl._foreign import ForeignFault, parse_json
from sloop_ppl._records import Fault, checked
from sloop_ppl.web import _limits
from sloop_ppl.web._refusal import Refusal

__all__ = ["body_of", "record_of"]

T = TypeVar("T")


async def body_of(request: Request, most_bytes: int) -> bytes:
    """Return the body of a request.

    Raises
    ------
    Refusal
        When it is larger, or takes too long to come.
    """
    declared = request.headers.get("content-length", "0")
    if declared.isdigit() and int(declared) > most_bytes:
        raise Refusal(413, f"The request has {declared} bytes; expected {most_bytes} at most")
    parts, size = [], 0
    try:
        async with asyncio.timeout(_limits.SECONDS_FOR_A_BODY):
            async for part in request.stream():
                size += len(part)
                if size > most_bytes:
                    raise Refusal(413, f"The request is too large; expected {most_bytes} bytes")
                parts.append(part)
    except TimeoutError:
        raise Refusal(408, "The request took too long to come") from None
    return b"".join(parts)


async def record_of(request: Request, kind: type[T]) -> T:
    """Return the JSON body of a request as a record.

    Raises
    ------
    Refusal
        When it is no JSON, or does not follow the record.
    """
    if request.headers.get("content-type", "").partition(";")[0].strip() != "application/json":
        raise Refusal(415, "The request is no application/json")
    data = await body_of(request, _limits.MOST_BODY_BYTES)
    try:
        return checked(parse_json(data.decode("utf-8")), kind)
    except (UnicodeDecodeError, ForeignFault) as error:
        raise Refusal(400, f"The request is not JSON: {error}") from None
    except Fault as fault:
        raise Refusal(400, f"The request's field '{fault.field}' {fault.what}") from None
