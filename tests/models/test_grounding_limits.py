"""How much a description may say."""

from __future__ import annotations

import pytest

from sloop_ppl.errors import DescriptionError
from sloop_ppl.models import ground_description, grounding, preset
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(15), house=(12.0, -7.0), street_y=30.0)


def test_more_relations_than_are_taken_are_refused(monkeypatch):
    monkeypatch.setattr(grounding, "MOST_RELATIONS", 3)
    known = said(*[relation("near", "House")] * 3)
    assert len(ground_description(known, CITY, preset("bayes"))[TARGET]) == 3
    with pytest.raises(DescriptionError, match="has 6 relations; expected at most 3: give it in"):
        ground_description((known, known), CITY, preset("bayes"))
