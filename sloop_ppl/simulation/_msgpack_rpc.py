"""A server of msgpack-rpc over TCP: requests in, responses out, in whatever order they are done."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import Any

from sloop_ppl.errors import InputError

__all__ = ["Handler", "RpcServer", "msgpack_module"]

_LOG = logging.getLogger(__name__)

# Types of messages, from the specification of msgpack-rpc.
_REQUEST, _RESPONSE, _NOTIFY = 0, 1, 2

_MOST_BYTES = 1 << 20
"""A request that is larger is none of a client's: no call that is served takes a picture."""

Handler = Callable[[str, list[Any]], Awaitable[Any]]
"""Carries out a call, name and arguments, and returns its result; what it raises is the error."""


def msgpack_module() -> Any:
    """Return msgpack, or say which extra has it."""
    try:
        import msgpack
    except ImportError:
        raise InputError(
            "Speaking with AirSim's clients needs msgpack; expected pip install 'sloop-ppl[sim]'"
        ) from None
    return msgpack


class RpcServer:
    """Listens on a port and answers requests.

    Parameters
    ----------
    handler
        Carries out the calls.

    Attributes
    ----------
    port
        Where it listens, once it does.
    """

    def __init__(self, handler: Handler) -> None:
        self._msgpack, self._handler = msgpack_module(), handler
        self._server: asyncio.Server | None = None
        self._clients: dict[asyncio.Task[Any], asyncio.StreamWriter] = {}
        self.port = 0

    async def listen(self, port: int, host: str) -> None:
        """Start to listen.

        Raises
        ------
        InputError
            When the address cannot be had.
        """
        try:
            self._server = await asyncio.start_server(self._serve, host, port)
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or error
            raise InputError(
                f"Address {host}:{port} cannot be listened on ({reason}); give another --serve port"
            ) from None
        self.port = self._server.sockets[0].getsockname()[1]

    async def close(self) -> None:
        """Stop listening and hang up."""
        if self._server is not None:
            # A client that is accepted this moment becomes known a few turns of the loop later;
            # a server that is closed meanwhile would leave its socket open.
            await asyncio.sleep(0.01)
            self._server.close()
            for writer in self._clients.values():
                writer.close()
            if self._clients:
                await asyncio.wait(self._clients, timeout=1.0)
            await self._server.wait_closed()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        this = asyncio.current_task()
        assert this is not None  # a coroutine runs in a task
        self._clients[this] = writer
        tasks: set[asyncio.Task[None]] = set()
        unpacker = self._msgpack.Unpacker(max_buffer_size=_MOST_BYTES)
        try:
            while data := await reader.read(1 << 16):
                unpacker.feed(data)
                for message in unpacker:
                    # Each in a task of its own: a pose is answered while a flight goes on.
                    task = asyncio.create_task(self._answer(_checked(message), writer))
                    tasks.add(task)
                    task.add_done_callback(tasks.discard)
        except (ValueError, self._msgpack.UnpackException) as error:
            _LOG.warning("A client was hung up on: %s", error)
        except ConnectionError:
            pass  # it hung up itself
        finally:
            for task in tasks:
                task.cancel()
            del self._clients[this]
            writer.close()

    async def _answer(self, message: list[Any], writer: asyncio.StreamWriter) -> None:
        kind, *number, name, arguments = message
        error = result = None
        try:
            result = await self._handler(name, arguments)
        except InputError as mistake:
            error = str(mistake)
        except Exception as mistake:
            _LOG.exception("Call %s failed", name)
            error = f"{name} failed: {type(mistake).__name__}: {mistake}"
        if kind == _REQUEST and not writer.is_closing():
            writer.write(self._msgpack.packb([_RESPONSE, number[0], error, result]))


def _checked(message: Any) -> list[Any]:
    """Return a request or notification, or refuse what is neither."""
    if isinstance(message, list) and message:
        kind, *rest = message
        numbered = kind == _REQUEST and len(rest) == 3 and isinstance(rest[0], int)
        if numbered or (kind == _NOTIFY and len(rest) == 2):
            name, arguments = rest[-2:]
            if isinstance(name, str) and isinstance(arguments, list):
                return message
    raise ValueError("it does not speak msgpack-rpc")
