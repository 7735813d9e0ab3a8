"""What MkDocs calls while it builds the site: pages made of the code, links out of ``docs/``."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from _command_line import command_line_page
from _links import mend_links
from _package_tree import link_package
from _reference import reference_pages
from _signatures import use_own_formatter
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[2]
# Pages of the repository's root -> their place in the site.
FROM_ROOT = {"CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md"}
# Pages that may not be there: section, title, file.
OPTIONAL = (
    ("Concepts", "Simulation", "simulation.md"),
    ("How to", "AirSim", "airsim.md"),
    ("Results", "Performance", "performance.md"),
)
_ROLE = re.compile(r":(?:func|class|mod|meth|data|attr|obj|exc):(?=<code>)")
_PICTURE = re.compile(r'(<a\b[^>]*>\s*)?(<img\b[^>]*?\bsrc="([^"]+)"[^>]*>)')


def on_startup(**_: Any) -> None:
    """Lay the package out as it is imported; plugins look for it when they are configured."""
    link_package(ROOT, ROOT / "build" / "docs" / "tree")


def on_config(config: Any) -> Any:
    """Put what is there into the navigation."""
    use_own_formatter()
    config.nav = [_filled(entry, Path(config.docs_dir)) for entry in config.nav]
    return config


def _filled(entry: dict[str, Any], docs: Path) -> dict[str, Any]:
    """Return a section of the navigation with the pages that are made or may be there."""
    ((title, below),) = entry.items()
    if title == "Reference":
        return {title: [{name: page} for page, (name, _) in _made_pages().items()]}
    more = [{name: page} for at, name, page in OPTIONAL if at == title and (docs / page).exists()]
    if not more:
        return entry
    return {title: [*([below] if isinstance(below, str) else below), *more]}


def _made_pages() -> dict[str, tuple[str, str]]:
    """Return path of each page of the reference -> its title and its text."""
    return {
        **reference_pages(),
        "reference/command_line.md": ("Command line", command_line_page()),
    }


def on_files(files: Files, config: Any) -> Files:
    """Add the reference, and the pages that lie in the root of the repository."""
    for page, (_, text) in _made_pages().items():
        files.append(File.generated(config, page, content=text))
    for source, page in FROM_ROOT.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        files.append(File.generated(config, page, content=text))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, **_: Any) -> str:
    """Let links to the source lead to the repository, and those to the root to their page."""
    uri = page.file.src_uri
    at_root = uri in FROM_ROOT.values()
    return mend_links(markdown, uri, config.extra["repository"], FROM_ROOT, at_root=at_root)


def on_page_content(html: str, **_: Any) -> str:
    """Link each picture to its file, and drop the marks of roles: ``:func:`` is for Sphinx."""
    return _PICTURE.sub(_linked, _ROLE.sub("", html))


def _linked(picture: re.Match[str]) -> str:
    """Return a picture as a link to its file, where a phone can enlarge it."""
    before, image, source = picture.groups()
    return picture[0] if before else f'<a href="{source}">{image}</a>'
