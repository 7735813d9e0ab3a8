"""Rebuild sloop_ppl/data/ordinary_words.txt.gz from the word lists of Debian's package scowl.

Run ``apt-get install scowl`` first, then ``python tests/tools/build_ordinary_words.py``. The levels
10 and 20 (common words) come first, after an empty line those of level 35; without words that have
capitals, apostrophes or accents.
"""

from __future__ import annotations

import gzip
import sys
from pathlib import Path

FOLDER = Path("/usr/share/dict/scowl")
OUT = Path(__file__).parents[2] / "sloop_ppl" / "data" / "ordinary_words.txt.gz"
LISTS = ("english", "american", "british")


def words(folder: Path, *levels: int) -> set[str]:
    """Return the lower-case words of some levels."""
    return {
        word
        for name in LISTS
        for level in levels
        for word in (folder / f"{name}-words.{level}").read_text("latin-1").split()
        if word.isascii() and word.isalpha() and word.islower()
    }


def main(folder: Path = FOLDER, out: Path = OUT) -> None:
    """Write the file; the same lists give the same bytes."""
    common = words(folder, 10, 20)
    text = "\n".join((*sorted(common), "", *sorted(words(folder, 35) - common), ""))
    out.write_bytes(gzip.compress(text.encode(), mtime=0))


if __name__ == "__main__":
    main(*(Path(a) for a in sys.argv[1:]))
