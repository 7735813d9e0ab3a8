"""Measure two cures for counting twice what several phrases share.

Run: python benchmarks/double_counting.py [FILE.jsonl ...] [--quick]

Phrases of one description are not independent: their product is too sure of itself, the more so
the more phrases there are. Under each model the share of targets inside the region that holds 90 %
of the belief is printed by number of gold relations, with the mean log score: as it is, tempered
(``temper=0.5``: the log likelihood of L phrases is divided by the root of L), and with an error
that all phrases share (``error_m=10``). 0.90 is right. The product of heavy tails is ``bayes`` with
numbers set by hand, so that none was learnt from the descriptions it is scored on. Without files
the bundled examples are taken, with --quick a few of them.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import torch

from sloop_ppl.eval import bundled_examples, read_descriptions, score_beliefs
from sloop_ppl.eval._belief_scores import ScoredTarget
from sloop_ppl.models import Component, preset
from sloop_ppl.models.bayes import unfitted

CURES = {
    "none": {"temper": 0.0, "error_m": 0.0},
    "temper .5": {"temper": 0.5, "error_m": 0.0},
    "error_m 10": {"temper": 0.0, "error_m": 10.0},
}


def main() -> None:
    """Print one row per model and cure."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("files", nargs="*", help="description files, .jsonl")
    options.add_argument("--quick", action="store_true", help="show that it runs, in seconds")
    given = options.parse_args()
    descriptions = read_descriptions(given.files) if given.files else bundled_examples()
    if given.quick:
        descriptions = descriptions[::5]
    torch.set_num_threads(1)
    product = replace(
        unfitted(preset("bayes")),
        name="student-vonmises product",
        components=(Component("product"),),
    )
    models = {
        (model.name, cure): replace(model, **changes)
        for model in (preset("sloop-m4"), product)
        for cure, changes in CURES.items()
    }
    named = {f"{name}, {cure}": model for (name, cure), model in models.items()}
    quality = score_beliefs(descriptions, named, rng=np.random.default_rng(0))
    print("| model | cure | log score | 1 relation | 2 | 3 and more | all |")
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: |")
    for (name, cure), scored in zip(models, quality.models.values(), strict=True):
        counts = {
            "1": [t for t in scored.scores if len(t.relations) == 1],
            "2": [t for t in scored.scores if len(t.relations) == 2],
            "3+": [t for t in scored.scores if len(t.relations) > 2],
            "all": list(scored.scores),
        }
        cells = " | ".join(cell_text(targets) for targets in counts.values())
        print(f"| {name} | {cure} | {scored.mean_log_score:.2f} | {cells} |")


def cell_text(targets: Sequence[ScoredTarget]) -> str:
    """Return the coverage of some targets, and how many they are."""
    if not targets:
        return "-"
    return f"{np.mean([t.score.in_hpd90 for t in targets]):.2f} ({len(targets)})"


if __name__ == "__main__":
    main()
