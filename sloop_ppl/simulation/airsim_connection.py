"""Connect to an AirSim through the official client, and say in one line what a call did wrong."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable
from typing import Any, TypeVar

from sloop_ppl.errors import InputError, on_one_line
from sloop_ppl.simulation._msgpack_rpc import msgpack_module
from sloop_ppl.simulation.airsim_server import AIRSIM_PORT

__all__ = ["asked", "connect", "refuse_running_loop"]

T = TypeVar("T")


def connect(host: str = "127.0.0.1", port: int = AIRSIM_PORT, timeout_s: float = 300.0) -> Any:
    """Return a client of the AirSim that listens at an address.

    Parameters
    ----------
    host, port
        The address.
    timeout_s
        How long a single call may take, seconds.

    Returns
    -------
    cosysairsim.MultirotorClient
        Connected, and of a version that the server takes.

    Raises
    ------
    InputError
        When the client is not installed, an event loop is running in this thread, or nothing that
        speaks AirSim's calls answers.
    """
    try:
        import cosysairsim
    except ImportError:
        raise InputError(
            "AirSim's client is not installed; expected pip install 'sloop-ppl[airsim]'"
        ) from None
    refuse_running_loop()
    _refuse_silence(host, port)
    client = cosysairsim.MultirotorClient(host, port, timeout_value=timeout_s)
    wanted, has = asked(client.getMinRequiredClientVersion), client.getClientVersion()
    if has < wanted:
        raise InputError(
            f"The AirSim at {host}:{port} wants clients of version {wanted}, cosysairsim has "
            f"{has}; expected pip install --upgrade cosysairsim"
        )
    return client


def asked(call: Callable[[], T]) -> T:
    """Return what a call of the client returns; its errors are the user's to read."""
    try:
        return call()
    except Exception as error:
        # Of RPCError and its kinds, by name: a client of one's own need not have the package.
        if not any(kind.__name__ == "RPCError" for kind in type(error).__mro__):
            raise
        raise InputError(
            f"AirSim did not carry out a call: {on_one_line(str(error))}; expected a simulator "
            "that runs, with a multirotor in it"
        ) from None


def refuse_running_loop() -> None:
    """Refuse to go on where an event loop runs: the client runs its own and cannot do so inside."""
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return
    raise InputError(
        "AirSim's client was called while an event loop is running in this thread (an async "
        "function, a notebook cell); expected a thread without one: asyncio.to_thread(...)"
    )


def _refuse_silence(host: str, port: int, timeout_s: float = 5.0) -> None:
    """Refuse an address at which nothing answers a ping.

    The client itself would wait for an hour where something else listens.
    """
    msgpack = msgpack_module()
    expected = "expected an AirSim that runs, or sloop fly --serve PORT"
    answers: list[Any] = []
    try:
        with socket.create_connection((host, port), timeout=timeout_s) as connection:
            connection.sendall(msgpack.packb([0, 0, "ping", []]))
            unpacker = msgpack.Unpacker(max_buffer_size=1 << 16)
            while not answers and (data := connection.recv(1 << 12)):
                unpacker.feed(data)
                answers += unpacker
    except (OSError, OverflowError) as error:
        reason = "no answer" if isinstance(error, TimeoutError) else error
        raise InputError(f"No AirSim at {host}:{port} ({reason}); {expected}") from None
    except (ValueError, msgpack.UnpackException):
        pass  # no msgpack
    if answers[:1] != [[1, 0, None, True]]:
        raise InputError(
            f"What listens at {host}:{port} is no AirSim: it does not answer a ping; {expected}"
        )
