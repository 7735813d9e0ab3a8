"""Draw the generative model of one sentence as a graph of its sites.

What the sentence leaves open is written by hand, so that the picture has one of each: which lot is
meant, and whether anything was read right at all.

Run: python examples/program_graph.py [program.dot]

Pyro draws the program itself: `pyro.render_model` runs it once and notes what each site depends on.
The file is in graphviz's language; `dot -Tpng program.dot -o program.png` makes the picture that
docs/models.md shows.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pyro

import sloop_ppl as sloop
from sloop_ppl.language import Candidate, Description, Reading, SpatialRelation, TargetObject
from sloop_ppl.models import build

TEXT = "The green Toyota is behind Velvet Dog and near the block."
BLOCKS = (Candidate("HoytBlock", 0.5), Candidate("StoneBlock", 0.4), Candidate(None, 0.1))


def description() -> Description:
    """Return the sentence with one reading of two phrases, and nothing as another."""
    car = TargetObject("GreenToyota", ("green toyota",), "green", "car")
    behind = SpatialRelation(car.id, "behind", ("VelvetDog",))
    near = SpatialRelation(car.id, "near", ("HoytBlock",), candidates=(BLOCKS,))
    said = Description(TEXT, "cleveland", (car,), (behind, near))
    return replace(said, readings=(Reading(0.9, said.relations), Reading(0.1)))


def main(path: str | Path = "program.dot") -> Any:
    """Write the graph and return it."""
    graph = pyro.render_model(
        build(description(), sloop.load_map("cleveland"), "bayes"),
        render_distributions=True,
        render_deterministic=True,
    )
    Path(path).write_text(graph.source + "\n", encoding="utf-8")
    return graph


if __name__ == "__main__":
    main(*sys.argv[1:2])
