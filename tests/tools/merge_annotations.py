"""Print how far two annotations of the same texts agree, and write the gold they make together.

Run: python tests/tools/merge_annotations.py A.jsonl B.jsonl [--gold GOLD.jsonl] [--keep DIR]

Each line has the id of a text and its relations (`docs/descriptions.md`), never the text itself.
What both annotators took is required, what one took is optional. "corner", which is no relation
word of the package, is read as at, as the bundled examples have it. `--keep` writes both
annotations as they were used, without fields that say nothing: the data in tests/eval/data.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from sloop_ppl.eval._agreement import agreement, merged
from sloop_ppl.eval._annotation_files import read_annotations, write_annotations
from sloop_ppl.eval._gold import GoldEntry, gold_entries
from sloop_ppl.eval._line_format import AnnotationLine, checked

WORDS = {"corner": "at"}


def read(path: Path) -> dict[str, tuple[GoldEntry, ...]]:
    """Return one annotator's file, in words that the package knows."""
    found = {}
    for line in filter(str.strip, path.read_text(encoding="utf-8").split("\n")):
        data = json.loads(line)
        for entry in data["relations"]:
            entry["relation"] = WORDS.get(entry["relation"], entry["relation"])
        known = checked(data, AnnotationLine)
        found[known.id] = gold_entries(known.relations)
    return found


def main() -> None:
    """Do what is asked."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("first", type=Path)
    options.add_argument("second", type=Path)
    options.add_argument("--gold", type=Path, help="where the gold is written")
    options.add_argument("--keep", type=Path, help="folder for both annotations as used")
    given = options.parse_args()
    first, second = read(given.first), read(given.second)
    for title, required in (("all entries", False), ("required by both", True)):
        print(f"{title:18} {'A':>5} {'B':>5} {'both':>5} {'F1':>6} {'of A':>6} {'of B':>6}")
        for name, found in agreement(first, second, required=required).items():
            print(
                f"{name:18} {found.first:5} {found.second:5} {found.both:5} {found.f1:6.3f} "
                f"{found.of_first:6.3f} {found.of_second:6.3f}"
            )
    gold = merged(first, second)
    entries = [entry for line in gold.values() for entry in line]
    print(
        f"gold: {len(gold)} texts, {len(entries)} entries, "
        f"{sum(not entry.optional for entry in entries)} required"
    )
    if given.gold:
        write_annotations(given.gold, gold)
        assert read_annotations(given.gold) == gold
    if given.keep:
        for name, annotations in ((given.first.name, first), (given.second.name, second)):
            write_annotations(given.keep / name.lower(), annotations)


if __name__ == "__main__":
    main()
