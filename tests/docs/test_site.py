"""The site builds without a warning, has every public name, and asks nothing of the network."""

from __future__ import annotations

import json
import os
import posixpath
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from importlib import import_module
from pathlib import Path
from types import ModuleType
from urllib.parse import unquote

import pytest
from support.tree import ROOT

for needed in ("mkdocs", "material", "mkdocstrings", "mkdocstrings_handlers.python"):
    pytest.importorskip(needed, reason="the site needs pip install 'sloop-ppl[docs]'")
sys.path.insert(0, str(ROOT / "docs" / "site_tools"))
from _links import mend_links  # noqa: E402
from _reference import REFERENCE  # noqa: E402
from _signatures import break_signature  # noqa: E402
from hooks import OPTIONAL  # noqa: E402

sys.path.pop(0)

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("site")]
# Tag -> attributes that a browser fetches.
FETCHED = {
    "audio": ("src",), "embed": ("src",), "iframe": ("src",), "img": ("src", "srcset"),
    "input": ("src",), "link": ("href",), "object": ("data",), "script": ("src",),
    "source": ("src", "srcset"), "track": ("src",), "video": ("src", "poster"),
}  # fmt: skip
NOT_FETCHED = {"canonical", "next", "prev"}  # of <link rel=...>


class Page(HTMLParser):
    """What a page fetches, links to, and can be linked to at."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.links: list[str] = []
        self.ids: set[str] = set()
        self.components: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        named = {key: value or "" for key, value in attrs}
        self.ids |= {named[key] for key in ("id", "name") if named.get(key)}
        self.components |= {named.get("data-md-component", "")}
        if tag == "a" and "href" in named:
            self.links.append(named["href"])
        if tag == "link" and named.get("rel") in NOT_FETCHED:
            return
        self.fetched += [named[key] for key in FETCHED.get(tag, ()) if key in named]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    out = tmp_path_factory.mktemp("site")
    # As in a fresh copy: what an earlier build has laid out must not be needed.
    shutil.rmtree(ROOT / "build" / "docs", ignore_errors=True)
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(out)],
        cwd=ROOT, capture_output=True, text=True, check=False,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    assert "WARNING" not in done.stderr
    return out


@pytest.fixture(scope="module")
def pages(site):
    return {path.relative_to(site).as_posix(): Page(path) for path in site.rglob("*.html")}


def test_it_has_every_page(pages):
    sources = [
        p.relative_to(ROOT / "docs").with_suffix(".html") for p in (ROOT / "docs").rglob("*.md")
    ]
    assert {path.as_posix() for path in sources} <= set(pages)
    assert {"changelog.html", "contributing.html", "reference/command_line.html"} <= set(pages)
    assert len(pages) > 50


def test_every_public_name_is_in_the_reference(pages):
    missing = []
    for module, page in REFERENCE.items():
        if f"reference/{page}.html" not in pages:
            assert module == "sloop_ppl.simulation"  # not of every version
            continue
        parent = module.rpartition(".")[0]
        known = set(import_module(parent).__all__) if parent in REFERENCE else set()
        room = import_module(module)
        for name in set(room.__all__) - known:
            if isinstance(getattr(room, name), ModuleType):
                continue
            if f"{module}.{name}" not in pages[f"reference/{page}.html"].ids:
                missing.append(f"{module}.{name}")
    assert missing == []


def test_no_page_is_without_a_place_in_the_navigation():
    config = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    placed = set(re.findall(r"([\w/]+\.md)$", config, re.MULTILINE)) | {
        page for *_, page in OPTIONAL
    }
    written = {p.relative_to(ROOT / "docs").as_posix() for p in (ROOT / "docs").rglob("*.md")}
    assert written <= placed


def test_every_link_leads_to_a_page_and_a_place_in_it(site, pages):
    broken = []
    for name, page in pages.items():
        if name == "404.html":
            continue  # its links begin at the root of a server
        for link in page.links:
            if re.match(r"[a-z]+:", link):
                continue
            path, _, place = link.partition("#")
            target = posixpath.join(posixpath.dirname(name), unquote(path)) if path else name
            target = posixpath.normpath(target)
            there = (site / target).is_file() or (site / target / "index.html").is_file()
            if not there or (place and target in pages and unquote(place) not in pages[target].ids):
                broken.append(f"{name}: {link}")
    assert broken == []


def test_nothing_is_fetched_from_elsewhere(site, pages):
    for name, page in pages.items():
        for source in page.fetched:
            assert not re.match(r"(https?:)?//", source), f"{name} fetches {source}"
            if name != "404.html" and not source.startswith("data:"):
                assert ((site / name).parent / source.partition("?")[0]).exists(), (name, source)
        # The theme's box on the repository asks its host for stars.
        assert "source" not in page.components, name
    for style in site.rglob("*.css"):
        assert not re.search(r"url\(['\"]?(https?:)?//|@import", style.read_text("utf-8")), style


def test_it_can_be_searched_without_a_server(site):
    index = (site / "search" / "search_index.js").read_text(encoding="utf-8")
    assert index.startswith("var __index = ")
    found = json.loads(index.removeprefix("var __index = "))["docs"]
    texts = {entry["location"]: entry["title"] + entry["text"] for entry in found}
    assert "plot_belief" in texts["gallery.html#plot_belief"]
    assert any(at.startswith("reference/maps.html#sloop_ppl.maps.CityMap") for at in texts)
    shim = (ROOT / "docs" / "assets" / "iframe-worker.js").read_text(encoding="utf-8")
    assert "IFrameWorker" in shim
    assert "MIT" in shim.splitlines()[0]


@pytest.mark.parametrize(
    ("link", "uri", "at_root", "expected"),
    [
        ("../models/program.py", "models.md", False, "REPO/blob/main/models/program.py"),
        ("../CONTRIBUTING.md", "models.md", False, "contributing.md"),
        (
            "../../CONTRIBUTING.md#add-a-plot",
            "howto/index.md",
            False,
            "../contributing.md#add-a-plot",
        ),
        ("../search.md#planners", "howto/planner.md", False, "../search.md#planners"),
        ("docs/maps.md", "changelog.md", True, "maps.md"),
        ("README.md", "contributing.md", True, "index.md"),
        ("#here", "models.md", False, "#here"),
        ("https://pyro.ai", "models.md", False, "https://pyro.ai"),
    ],
)
def test_links_hold_in_the_repository_and_on_the_site(link, uri, at_root, expected):
    roots = {"CONTRIBUTING.md": "contributing.md"}
    text = f"[a]({link})\n```\n[a]({link})\n```\n"
    mended = mend_links(text, uri, "REPO", roots, at_root=at_root)
    assert mended == f"[a]({expected})\n```\n[a]({link})\n```\n"


def test_long_signatures_are_broken_at_their_own_commas():
    short = "def f(a: int) -> int: pass"
    assert break_signature(short, 80) == short
    long = "def f(a: Mapping[str, int], *, b: str = 'x, y', c: tuple = (1, 2)) -> None: pass"
    assert break_signature(long, 40) == (
        "def f(\n    a: Mapping[str, int],\n    *,\n    b: str = 'x, y',\n    c: tuple = (1, 2),\n"
        ") -> None: pass"
    )
    assert break_signature("x = [1, 2, 3]", 5) == "x = [1, 2, 3]"
