"""Run the application on this machine."""

from __future__ import annotations

import socket
import webbrowser
from collections.abc import Callable

from sloop_ppl.errors import InputError
from sloop_ppl.web.application import WebSettings, application

__all__ = ["serve"]


def serve(
    settings: WebSettings,
    port: int = 8765,
    *,
    open_browser: bool = False,
    notify: Callable[[str], None],
) -> None:
    """Serve the pages until Ctrl-C.

    Parameters
    ----------
    settings
        What the application is made with.
    port
        TCP port; 0 for any that is free.
    open_browser
        Open the workbench in the user's browser.
    notify
        Called with the address, token included, once it can be opened.

    Raises
    ------
    InputError
        When the port cannot be had.
    SloopError
        When a map, the queue or the study cannot be read.
    """
    import uvicorn

    app = application(settings)
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    listening = socket.socket(family, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((settings.host, port))
        listening.listen(128)  # who comes before the server is up waits
    except (OSError, OverflowError) as error:
        listening.close()
        reason = getattr(error, "strerror", None) or error
        raise InputError(
            f"Port {port} of {settings.host} cannot be had: {reason}; give another --port"
        ) from error
    shown = f"[{settings.host}]" if ":" in settings.host else settings.host
    address = f"http://{shown}:{listening.getsockname()[1]}/?token={settings.token}"
    config = uvicorn.Config(
        app,
        access_log=False,  # addresses hold the token
        log_level="warning",
        server_header=False,
        timeout_keep_alive=30,
        timeout_graceful_shutdown=3,
        limit_concurrency=200,
        h11_max_incomplete_event_size=32 * 2**10,
    )
    notify(address)
    if open_browser:
        webbrowser.open(address)
    with listening:
        uvicorn.Server(config).run(sockets=[listening])
