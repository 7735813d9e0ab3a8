"""A server for the whole run, Chromium, and pictures."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from support.web_server import GUEST, TOKEN, running

from sloop_ppl.web.application import WebSettings

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
AXE = Path(__file__).parents[2] / "out/axe/node_modules/axe-core/axe.min.js"
QUIET = ["--no-sandbox", "--disable-background-networking", "--disable-component-update"]


@pytest.fixture(scope="session")
def server(tmp_path_factory):
    folder = tmp_path_factory.mktemp("web")
    with running(WebSettings(token=TOKEN, guest_token=GUEST, folder=folder)) as served:
        yield served


@pytest.fixture(scope="session")
def browser():
    if CHROMIUM is None:
        pytest.skip("there is no Chromium; make test-web installs it")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=QUIET)
        yield started
        started.close()


@pytest.fixture
def open_page(browser, server):
    """Return a function that opens a page; at the end nothing may have gone wrong in any."""
    contexts, faults = [], []

    def opened(path="/", *, ready=True, base=None, token=TOKEN, expected=(), **options):
        def log(message):
            if message.type == "error" and not any(e in message.text for e in expected):
                faults.append(message.text)

        options.setdefault("viewport", {"width": 1280, "height": 860})
        options.setdefault("accept_downloads", True)
        context = browser.new_context(**options)
        context.grant_permissions(["clipboard-read", "clipboard-write"])
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(120_000)  # other work may hold the processors
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", log)
        page.on("request", lambda r: faults.append(r.url) if is_foreign(r.url) else None)
        link, _, fragment = path.partition("#")
        query = f"{'&' if '?' in link else '?'}token={token}" if token else ""
        page.goto(f"{base or server.url}{link}{query}{'#' if fragment else ''}{fragment}")
        if ready:
            page.locator("body[data-ready]").wait_for()
        return page

    yield opened
    for context in contexts:
        context.close()
    assert faults == []


def is_foreign(url):
    return not url.startswith(("http://127.0.0.1:", "data:", "blob:", "file:"))


@pytest.fixture
def picture(request, tmp_path):
    """Return a function that keeps a picture of a page, for the docs where they are asked for."""
    folder = Path(request.config.getoption("--pictures") or tmp_path)
    folder.mkdir(parents=True, exist_ok=True)

    def keep(page, name):
        path = folder / f"{name}.png"
        page.screenshot(path=path, animations="disabled")
        assert path.stat().st_size > 10_000
        return path

    return keep
