"""Print which share of each room's statements the tests ran; ``make coverage`` calls it.

Code that numba compiles counts as not run: no tracer sees it.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path


def by_room(report: dict[str, dict[str, dict[str, dict[str, int]]]]) -> dict[str, tuple[int, int]]:
    """Return the statements that ran and all there are, by room, of what ``coverage json`` wrote.

    Parameters
    ----------
    report
        The parsed file.
    """
    ran: Counter[str] = Counter()
    all_: Counter[str] = Counter()
    for name, entry in report["files"].items():
        parts = Path(name).parent.parts
        room = "/".join(parts[:2] if parts[0] == "sloop_ppl" else parts[:1])
        ran[room] += entry["summary"]["covered_lines"]
        all_[room] += entry["summary"]["num_statements"]
    return {room: (ran[room], all_[room]) for room in sorted(all_)}


def main() -> None:
    """Print a line for each room."""
    rooms = by_room(json.loads(Path(sys.argv[1]).read_text()))
    rooms["all"] = tuple(map(sum, zip(*rooms.values(), strict=True)))  # type: ignore[assignment]
    print(f"{'room':20} {'statements':>10} {'ran':>7}")
    for room, (ran, statements) in rooms.items():
        print(f"{room:20} {statements:10} {ran / max(statements, 1):7.1%}")


if __name__ == "__main__":
    main()
