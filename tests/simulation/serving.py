"""A server in a thread of its own, and a raw client of msgpack-rpc, for the tests."""

from __future__ import annotations

import contextlib
import socket
import threading

import msgpack

from sloop_ppl.simulation import serve


@contextlib.contextmanager
def served(vehicle, **options):
    """Serve a vehicle on a free port; gives the server."""
    there, servers = threading.Event(), []

    def ready(server):
        servers.append(server)
        there.set()

    thread = threading.Thread(target=serve, args=(vehicle, 0), kwargs={"ready": ready, **options})
    thread.start()
    assert there.wait(10)
    try:
        yield servers[0]
    finally:
        servers[0].close()
        thread.join(10)
        assert not thread.is_alive()


class RawClient:
    """Sends requests and reads responses, one after the other or not."""

    def __init__(self, port):
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=10)
        self._unpacker, self._next, self._answers = msgpack.Unpacker(), 0, {}

    def send(self, name, *arguments):
        self._next += 1
        self._socket.sendall(msgpack.packb([0, self._next, name, list(arguments)]))
        return self._next

    def send_bytes(self, data):
        self._socket.sendall(data)

    def receive(self, number):
        while number not in self._answers:
            data = self._socket.recv(1 << 16)
            if not data:
                raise ConnectionError("hung up")
            self._unpacker.feed(data)
            for kind, answered, error, result in self._unpacker:
                assert kind == 1
                self._answers[answered] = error, result
        return self._answers.pop(number)

    def call(self, name, *arguments):
        error, result = self.receive(self.send(name, *arguments))
        if error is not None:
            raise RuntimeError(error)
        return result

    def close(self):
        self._socket.close()


@contextlib.contextmanager
def connected(server):
    client = RawClient(server.port)
    try:
        yield client
    finally:
        client.close()
