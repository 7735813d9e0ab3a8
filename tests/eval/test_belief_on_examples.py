"""The whole chain on the bundled examples, whose places were fixed before their sentences."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from sloop_ppl.eval import bundled_examples
from sloop_ppl.inference import infer_description
from sloop_ppl.language import Description, parse
from sloop_ppl.maps import load_map

city_of = cache(load_map)


def ranks(model: str, *, parsed: bool) -> list[float]:
    """Return the rank of each target's true cell: cells believed more, half of those as much."""
    found = []
    for annotated in bundled_examples():
        city = city_of(annotated.map)
        gold = Description(annotated.text, annotated.map, annotated.objects, annotated.relations)
        said = parse(annotated.text, city, targets=annotated.objects) if parsed else gold
        posterior, _ = infer_description(said, city, model)
        for target, place in annotated.targets.items():
            if target in posterior.targets:
                belief = posterior.belief(target)
            else:  # what was not read gets the uniform belief
                belief = np.full(city.grid.shape, 1 / city.grid.size)
            here = belief[place.cell]
            found.append((belief > here).sum() + ((belief == here).sum() - 1) / 2)
    return found


@pytest.mark.parametrize("parsed", [False, True], ids=["gold", "parsed"])
@pytest.mark.parametrize("model", ["sloop-m4", "bayes"])
def test_the_true_cell_ranks_among_the_first_40(model, parsed):
    found = ranks(model, parsed=parsed)
    assert len(found) >= 40
    assert np.median(found) < 40


def test_language_beats_no_language():
    assert np.median(ranks("sloop-m4", parsed=True)) < np.median(ranks("keyword", parsed=True))
    assert np.median(ranks("uniform", parsed=True)) == 840
