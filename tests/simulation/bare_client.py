"""The calls of AirSim's client that the environment makes, on nothing but a socket.

So that the environment is tested where the official client is not installed, too.
"""

from __future__ import annotations

from types import SimpleNamespace

from serving import RawClient

from sloop_ppl.simulation._airsim_colours import object_colours


class RPCError(Exception):
    """Named as the official one."""


class Flight:
    """Looks for its response whenever it is asked."""

    def __init__(self, client, number):
        self._client, self._number, self.answer = client, number, None

    def join(self):
        if self.answer is None:
            self.answer = self._client.raw.receive(self._number)

    def get(self):
        self.join()
        if self.answer[0] is not None:
            raise RPCError(self.answer[0])
        return self.answer[1]

    def _peek(self):
        if self.answer is None and self._number in self._client.raw._answers:
            self.join()
        return self.answer or (None, None)

    error = property(lambda self: self._peek()[0])
    result = property(lambda self: self._peek()[1])


def plain(value):
    if isinstance(value, dict):
        return SimpleNamespace(**{k: plain(v) for k, v in value.items()})
    return [plain(v) for v in value] if isinstance(value, list) else value


class BareClient:
    def __init__(self, port):
        self.raw = RawClient(port)

    def __getattr__(self, name):
        if name.endswith("Async"):
            wire = name.removesuffix("Async")
            return lambda *arguments: Flight(self, self.raw.send(wire, *arguments))
        return lambda *arguments: self._call(name, *arguments)

    def _call(self, name, *arguments):
        error, result = self.raw.receive(self.raw.send(name, *arguments))
        if error is not None:
            raise RPCError(error)
        return plain(result)

    def simGetSegmentationColorMap(self):  # noqa: N802 - AirSim's name
        return object_colours()
