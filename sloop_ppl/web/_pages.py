"""The pages themselves, their modules and their style sheet."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from importlib.resources import files

from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route

from sloop_ppl.web._stylesheet import static_text, style_sheet

__all__ = ["page_routes"]

_PAGES = {"/": "workbench.html", "/frames": "frames.html", "/collect": "collect.html",
          "/progress": "progress.html"}  # fmt: skip
# The names that exist when the server starts: what a request asks for opens no file.
_MODULES = frozenset(
    path.name for path in (files("sloop_ppl") / "web" / "static").iterdir()
    if path.name.endswith(".js")
)  # fmt: skip
_TEMPLATE = "page.html"
"""What a page fills in that is kept; it is text here, not a page."""


def page_routes() -> list[Route]:
    """Return the routes of pages and of what they load."""
    return [
        *(Route(path, _page(name), methods=["GET"]) for path, name in _PAGES.items()),
        Route("/static/style.css", _style, methods=["GET"]),
        Route("/static/{name}", _module, methods=["GET"]),
    ]


def _page(name: str) -> Callable[[Request], Awaitable[Response]]:
    async def page(_request: Request) -> Response:
        return Response(static_text(name), media_type="text/html; charset=utf-8")

    return page


async def _style(_request: Request) -> Response:
    return Response(style_sheet(), media_type="text/css")


async def _module(request: Request) -> Response:
    name = request.path_params["name"]
    if name == _TEMPLATE:
        return PlainTextResponse(static_text(name))
    if name not in _MODULES:
        return PlainTextResponse("There is no such module", 404)
    return Response(static_text(name), media_type="text/javascript; charset=utf-8")
