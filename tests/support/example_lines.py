"""A description file of a few of the bundled examples."""

from __future__ import annotations

import json
from importlib.resources import files


def write_examples(path, *wanted):
    """Write the examples of these ids; return the path."""
    lines = (files("sloop_ppl") / "data" / "examples.jsonl").read_text("utf-8").splitlines()
    path.write_text("\n".join(line for line in lines if json.loads(line)["id"] in wanted), "utf-8")
    return path
