"""Let in only who has the token, from this site's own pages; tell browsers to load nothing else."""

from __future__ import annotations

import ipaddress
import secrets
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qsl, urlencode, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

__all__ = ["CONTENT_SECURITY_POLICY", "Guard"]

CONTENT_SECURITY_POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self' data: blob:",
        "connect-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
"""What a page may load: only what this server sends."""

_HEADERS = {
    "content-security-policy": CONTENT_SECURITY_POLICY,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), microphone=(), geolocation=()",
    "cache-control": "no-store",
}
_READING = ("GET", "HEAD")


class Guard:
    """The outermost layer of the application.

    Pages and their modules are anyone's who reaches the port; every path below ``/api`` needs the
    token, in a cookie, as ``Authorization: Bearer``, or once as ``?token=`` of a page, which sets
    the cookie. `Host` must be this machine by number or name, so that no foreign name can be
    pointed at it (DNS rebinding); what changes anything must come from a page of the same origin.

    Parameters
    ----------
    app
        What is guarded.
    token
        The secret.
    host
        Where the server is bound; its name is accepted as `Host`.
    guest_token
        A second secret, with which only `guest_paths` can be asked.
    guest_paths
        Beginnings of those paths.
    """

    def __init__(
        self,
        app: ASGIApp,
        token: str,
        host: str,
        guest_token: str,
        guest_paths: tuple[str, ...],
    ) -> None:
        self._app, self._token = app, token
        self._guest_token, self._guest_paths = guest_token, guest_paths
        self._names = frozenset(("localhost", host.lower()))
        self._is_local = _is_loopback(host)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if scope["type"] != "http":  # no websockets here
            await send({"type": "websocket.close", "code": 1008})
            return

        async def send_guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        answer = self._answer(scope)
        await (answer or self._app)(scope, receive, send_guarded)

    def _answer(self, scope: Scope) -> Response | None:
        """Return what is answered without asking the application, or None."""
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if not self._is_here(host):
            return _no(421, "The Host of the request is not this machine")
        writing = scope["method"] not in _READING
        if writing and not _is_same_origin(headers, host):
            return _no(403, "The request comes from another site")
        query = parse_qsl(scope["query_string"].decode("latin-1"))
        port = host.rpartition(":")[2] if ":" in host else "80"
        cookie = f"sloop_{port}"  # cookies are shared by all ports of a host
        if not scope["path"].startswith("/api"):
            given = dict(query).get("token")
            if given is None or writing:
                return None
            rest = urlencode([pair for pair in query if pair[0] != "token"])
            response = RedirectResponse(f"{scope['path']}{'?' if rest else ''}{rest}", 303)
            if self._is_token(given, self._token) or self._is_token(given, self._guest_token):
                response.set_cookie(cookie, given, path="/", httponly=True, samesite="strict")
            return response
        presented = (_cookie(headers, cookie), headers.get("authorization", "")[len("Bearer ") :])
        known = [self._token]
        if scope["path"].startswith(self._guest_paths):
            known.append(self._guest_token)
        if not any(self._is_token(one, secret) for one in presented for secret in known):
            return _no(401, "The token is missing or wrong; open the address `sloop serve` printed")
        return None

    @staticmethod
    def _is_token(given: str, token: str) -> bool:
        return secrets.compare_digest(given.encode(), token.encode())

    def _is_here(self, host: str) -> bool:
        try:
            name = (urlsplit(f"//{host}").hostname or "").lower()
        except ValueError:
            return False
        if name in self._names:
            return True
        # Beyond loopback an address in numbers is accepted: no one can make it resolve elsewhere.
        return _is_loopback(name) if self._is_local else _is_address(name)


def _is_same_origin(headers: Headers, host: str) -> bool:
    """Tell whether a request that changes something comes from a page of ours, or no page."""
    if headers.get("sec-fetch-site", "same-origin") not in ("same-origin", "none"):
        return False
    origin = headers.get("origin")
    return origin is None or urlsplit(origin).netloc.lower() == host.lower()


def _cookie(headers: Headers, name: str) -> str:
    jar: SimpleCookie = SimpleCookie()
    try:
        jar.load(headers.get("cookie", ""))
    except CookieError:
        return ""
    return jar[name].value if name in jar else ""


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _is_loopback(name: str) -> bool:
    return name == "localhost" or (_is_address(name) and ipaddress.ip_address(name).is_loopback)


def _no(status: int, message: str) -> Response:
    return JSONResponse({"error": message}, status)
