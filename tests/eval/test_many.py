from __future__ import annotations

import numpy as np
import pytest

import sloop_ppl as sloop
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.eval import bundled_examples
from sloop_ppl.models import preset

TEXTS = ["the red bike is near Ivy", "what a nice day", "the green toyota is behind velvet dog"]


def test_each_is_what_infer_says_in_their_order():
    found = list(sloop.infer_many(iter(TEXTS), "cleveland"))
    assert [f.index for f in found] == [0, 1, 2]
    assert [f.text for f in found] == TEXTS
    for said in (found[0], found[2]):
        alone = sloop.infer(said.text, "cleveland")
        assert list(said.beliefs) == list(alone.targets)
        for target, belief in said.beliefs.items():
            np.testing.assert_allclose(belief, alone.belief(target), rtol=0, atol=1e-12)
    assert found[1].beliefs == {}
    assert "\n" not in found[1].fault
    assert "what a nice day" in repr(found[1])


def test_each_may_have_its_own_map_and_two_processes_say_the_same():
    pairs = [(example.text, example.map) for example in bundled_examples()]
    counts = []
    one = list(sloop.infer_many(pairs, workers=1))
    two = list(sloop.infer_many(pairs, workers=2, progress=counts.append))
    assert counts[-1] == len(pairs)
    assert counts == sorted(counts)
    assert [f.map_name for f in one] == [name for _, name in pairs]
    assert [f.index for f in two] == list(range(len(pairs)))
    for a, b in zip(one, two, strict=True):
        assert list(a.beliefs) == list(b.beliefs)
        for target in a.beliefs:
            # fronts are predicted in float32, some together and some alone
            assert np.abs(a.beliefs[target] - b.beliefs[target]).sum() < 1e-5


def test_no_more_descriptions_are_taken_than_are_handed_out():
    taken = []

    def lines():
        for i in range(10_000):
            taken.append(i)
            yield TEXTS[0]

    results = sloop.infer_many(lines(), "cleveland", model="uniform")
    assert next(results).index == 0
    assert len(taken) < 100


def test_models_and_maps_of_ones_own_are_sent_to_the_workers():
    city = sloop.load_map("cleveland", cell_m=10)
    model = preset("bayes")
    said = [sloop.parse("the red bike is near Ivy", city)] * 40
    found = list(sloop.infer_many(said, city, model, workers=2))
    assert len(found) == 40
    assert found[0].beliefs["RedBike"].shape == city.grid.shape


@pytest.mark.parametrize(
    ("arguments", "options", "error", "message"),
    [
        ((TEXTS, "cleveland"), {"workers": 0}, InputError, "workers is 0"),
        ((TEXTS[0], "cleveland"), {}, InputError, "one description"),
        ((TEXTS,), {}, InputError, "a pair of a text and a map"),
        (([3], "cleveland"), {}, InputError, "Description 0 is 3; expected a text"),
        ((TEXTS, "cleveland"), {"backend": "threads"}, UnknownName, "threads"),
        ((TEXTS, "cleveland", "bays"), {}, UnknownName, "bays"),
    ],
)
def test_a_mistake_is_told_at_once(arguments, options, error, message):
    with pytest.raises(error, match=message):
        next(sloop.infer_many(*arguments, **options))


def test_a_map_that_is_not_there_is_the_fault_of_its_description():
    found = list(sloop.infer_many([(TEXTS[0], "atlantis"), (TEXTS[0], "cleveland")]))
    assert "atlantis" in found[0].fault
    assert found[1].fault is None
