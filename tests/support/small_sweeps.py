"""Small sweeps that several tests share: descriptions in a file, and what to ask of them."""

from __future__ import annotations

import json
from pathlib import Path

from sloop_ppl.eval._sweep_files import SweepRequest
from sloop_ppl.eval.trials import Searching

SHORT = Searching(planner="fast", sims=20, rollout="published", max_steps=6)

LINES = [
    {
        "id": "one",
        "map": "cleveland",
        "configuration": "a",
        "text": "The red bike is near Ivy and the green Toyota is behind Velvet Dog.",
        "targets": {
            "RedBike": {"east_m": -77.5, "north_m": 47.5},
            "GreenToyota": {"east_m": -2.5, "north_m": -32.5},
        },
        "relations": [
            {"figure": "RedBike", "relation": "near", "ground": "Ivy"},
            {"figure": "GreenToyota", "relation": "behind", "ground": "VelvetDog"},
        ],
    },
    {
        "id": "two",
        "map": "cleveland",
        "configuration": "b",
        "text": "The red bike is east of Spirits, near Rumor.",
        "targets": {"RedBike": {"east_m": 12.5, "north_m": -12.5}},
        "relations": [
            {"figure": "RedBike", "relation": "east", "ground": "Spirits"},
            {"figure": "RedBike", "relation": "near", "ground": "Rumor"},
        ],
    },
]


def write_lines(path: Path, *lines: dict) -> Path:
    """Write lines, those above when none are given, as a description file."""
    path.write_text("".join(json.dumps(line) + "\n" for line in lines or LINES))
    return path


def request(folder: Path, **changes) -> SweepRequest:
    """Return a request of a few short trials of a file in `folder`, into its folder ``run``."""
    file = folder / "said.jsonl"
    if not file.exists():
        write_lines(file)
    asked = {
        "files": [file],
        "out": folder / "run",
        "models": "uniform,sloop",
        "ranges": "3,4",
        "searching": SHORT,
        "workers": 1,
        **changes,
    }
    return SweepRequest(**asked)


def table_of(folder) -> list[dict]:
    """Return the trials of a run without their times."""
    told = [trial.to_json() for trial in folder.trials()]
    return [{k: v for k, v in one.items() if k != "seconds"} for one in told]
