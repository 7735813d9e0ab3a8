"""Links of pages that are read in the repository as well as on the site."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Mapping

__all__ = ["mend_links"]

_LINK = re.compile(r"(?<=\]\()(?![a-z]+:|#)([^)\s]+)(?=\))")
_NAMED_PAGE = re.compile(r"(?<!\[)`docs/(\w+)\.md`")
_FENCED = re.compile(r"(^```.*?^```)", re.DOTALL | re.MULTILINE)


def mend_links(
    markdown: str, uri: str, repo_url: str, from_root: Mapping[str, str], *, at_root: bool
) -> str:
    """Return the text of a page with links that hold on the site.

    Parameters
    ----------
    markdown
        The text, with links that hold in the repository.
    uri
        The page's place in the site, with the ending ``.md``.
    repo_url
        Where files that are no pages can be read.
    from_root
        Pages of the repository's root -> their place in the site.
    at_root
        Whether the page lies in the repository's root instead of ``docs/``.
    """
    here = "" if at_root else posixpath.dirname(posixpath.join("docs", uri))
    site_folder = posixpath.dirname(uri)

    def mended(match: re.Match[str]) -> str:
        path, mark, heading = match[1].partition("#")
        target = posixpath.normpath(posixpath.join(here, path))
        if target in from_root:
            target = posixpath.join("docs", from_root[target])
        elif target == "README.md":
            target = "docs/index.md"
        if target.startswith("docs/"):
            return posixpath.relpath(target[5:], site_folder or ".") + mark + heading
        return f"{repo_url}/blob/main/{target}{mark}{heading}"

    pieces = _FENCED.split(markdown)
    for number in range(0, len(pieces), 2):
        pieces[number] = _LINK.sub(mended, pieces[number])
        if at_root:
            pieces[number] = _NAMED_PAGE.sub(r"[\1](\1.md)", pieces[number])
    return "".join(pieces)
