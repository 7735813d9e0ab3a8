"""Draw the generative model of one sentence as a graph of its sites.

Run: python examples/program_graph.py [program.dot]

Pyro draws the program itself: `pyro.render_model` runs it once and notes what each site depends on.
The file is in graphviz's language; `dot -Tpng program.dot -o program.png` makes the picture that
docs/models.md shows.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pyro

import sloop_ppl as sloop
from sloop_ppl.models import build

TEXT = "The green Toyota is behind Velvet Dog and near Hoyt Block."


def main(path: str | Path = "program.dot") -> Any:
    """Write the graph and return it."""
    said = sloop.parse(TEXT, "cleveland")
    city = sloop.load_map("cleveland")
    graph = pyro.render_model(
        build(said, city, "bayes"), render_distributions=True, render_deterministic=True
    )
    Path(path).write_text(graph.source + "\n", encoding="utf-8")
    return graph


if __name__ == "__main__":
    main(*sys.argv[1:2])
