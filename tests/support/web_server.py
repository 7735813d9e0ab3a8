"""A server of the web application in a thread of this process, and plain requests to it."""

from __future__ import annotations

import http.client
import json
import socket
import threading
from contextlib import contextmanager

import uvicorn

from sloop_ppl.web.application import application

TOKEN, GUEST = "token-of-the-tests", "token-of-guests"


class WebServer:
    """Where a server listens, and how to ask it."""

    def __init__(self, port, settings):
        self.port, self.settings = port, settings
        self.url = f"http://127.0.0.1:{port}"

    def ask(self, method, path, body=None, *, token=TOKEN, headers=(), raw=None, timeout=60):
        """Return status, headers and body of a request."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout)
        sent = {"authorization": f"Bearer {token}"} if token else {}
        data = raw
        if body is not None:
            data, sent["content-type"] = json.dumps(body).encode(), "application/json"
        sent |= dict(headers)
        try:
            connection.request(method, path, data, sent)
            answer = connection.getresponse()
            return answer.status, dict(answer.getheaders()), answer.read()
        finally:
            connection.close()

    def json(self, method, path, body=None, **options):
        """Return status and the JSON of an answer."""
        status, _, content = self.ask(method, path, body, **options)
        return status, json.loads(content)


@contextmanager
def running(settings):
    """Serve until the block ends."""
    listening = socket.socket()
    listening.bind(("127.0.0.1", 0))
    listening.listen(128)
    config = uvicorn.Config(
        application(settings), log_level="error", access_log=False, timeout_graceful_shutdown=1
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]}, daemon=True)
    thread.start()
    try:
        yield WebServer(listening.getsockname()[1], settings)
    finally:
        server.should_exit = True
        thread.join(20)
        listening.close()
