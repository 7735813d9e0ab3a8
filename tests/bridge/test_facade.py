"""The functions of the top level take texts and names as well as values, and refuse the rest."""

from __future__ import annotations

import numpy as np
import pytest

import sloop_ppl as sloop
from sloop_ppl.errors import InputError, NoRelationFound, UnknownName
from sloop_ppl.inference import Exact, Importance
from sloop_ppl.maps import write_map

TEXT = "the red bike is near Ivy"


def test_a_text_and_a_name_are_what_a_description_and_a_map_are(tmp_path):
    city = sloop.load_map("cleveland")
    said = sloop.parse(TEXT, city)
    assert sloop.parse(TEXT, "cleveland") == said
    expected = sloop.infer(said, city).belief("RedBike")
    path = tmp_path / "mine.geojson"
    write_map(city, path)
    for given in ((TEXT, city), (said, "cleveland"), (TEXT, "cleveland"), (TEXT, path)):
        np.testing.assert_array_equal(sloop.infer(*given).belief("RedBike"), expected)


def test_an_engine_is_a_name_or_a_value_with_options():
    by_name = sloop.infer(TEXT, "cleveland", engine="exact")
    by_value = sloop.infer(TEXT, "cleveland", engine=Exact())
    np.testing.assert_array_equal(by_name.belief("RedBike"), by_value.belief("RedBike"))
    behind = "the red bike is behind Ivy"
    few, same, many = (
        sloop.infer(behind, "cleveland", engine=engine, rng=np.random.default_rng(0))
        for engine in (Importance(draws=50), Importance(50), "importance")
    )
    exact = sloop.infer(behind, "cleveland")

    def apart(posterior):
        return np.abs(posterior.belief("RedBike") - exact.belief("RedBike")).sum()

    assert few.engine == many.engine == "importance"
    assert few.method == Importance(50)
    assert apart(few) == apart(same) > apart(many)


@pytest.mark.parametrize(
    ("given", "options", "error", "message"),
    [
        (("hello", "cleveland"), {}, NoRelationFound, "No relation found in 'hello'; recognised"),
        ((3, "cleveland"), {}, InputError, "What was said is a int; expected a text, or a Desc"),
        ((TEXT, 7), {}, InputError, "The map is a int; expected a CityMap, the name of a bundled"),
        ((TEXT, "nowhere"), {}, UnknownName, "Map 'nowhere' is unknown; expected one of austin"),
        ((TEXT, "cleveland"), {"engine": 3}, InputError, "Engine is a int; expected one of the n"),
        ((TEXT, "cleveland"), {"engine": Importance}, InputError, "Engine is the class Importance"),
        ((TEXT, "cleveland"), {"engine": "exakt"}, UnknownName, "did you mean 'exact'"),
    ],
)
def test_bad_input_is_one_line(given, options, error, message):
    with pytest.raises(error) as told:
        sloop.infer(*given, **options)
    assert message in str(told.value)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize("draws", [0, -1, 2.5, True, "many"])
def test_options_of_an_engine_are_checked_when_it_is_made(draws):
    with pytest.raises(InputError, match=r"Importance has draws .*; expected a whole number above"):
        Importance(draws=draws)
