"""The bundled examples: they cover the vocabulary, and what they say is true on their maps."""

import math
from collections import Counter

import numpy as np
import pytest
import shapely

from sloop_ppl.eval import bundled_examples
from sloop_ppl.inference import infer_description
from sloop_ppl.language import RELATIONS, Description
from sloop_ppl.maps import bundled_maps, load_map

COMPASS_DEG = {
    "east": 0, "northeast": 45, "north": 90, "northwest": 135,
    "west": 180, "southwest": 225, "south": 270, "southeast": 315,
}  # fmt: skip
OFFSET_DEG = {"front": 0, "behind": 180, "left": 90, "right": -90}

SCENES = bundled_examples()
SAID = [
    pytest.param(annotated, relation, id=f"{annotated.id}-{relation.figure}-{relation.relation}")
    for annotated in SCENES
    for relation in annotated.relations
]


def seen_from(annotated, relation, ground):
    """Return distance in metres and bearing in radians of the true cell from a ground."""
    fields = load_map(annotated.map).fields(ground)
    cell = annotated.targets[relation.figure].cell
    return float(fields.distance_m[cell]), float(fields.bearing_rad[cell])


def test_every_relation_word_is_said():
    assert {r.relation for s in SCENES for r in s.relations} == set(RELATIONS)


def test_every_map_has_examples_of_two_targets():
    assert set(Counter(s.map for s in SCENES)) == set(bundled_maps())
    assert {len(s.targets) for s in SCENES} == {2}
    assert {o for s in SCENES for o in s.targets} == {"GreenToyota", "RedHonda", "RedBike"}


def test_those_who_describe_one_configuration_saw_the_same_places():
    places = {}
    for annotated in SCENES:
        assert places.setdefault(annotated.configuration, annotated.targets) == annotated.targets
    assert len(places) < len(SCENES)


def test_every_target_is_spoken_of():
    for annotated in SCENES:
        assert {r.figure for r in annotated.relations} == set(annotated.targets), annotated.id


def test_one_is_negated_and_one_has_several_grounds():
    said = [r for s in SCENES for r in s.relations]
    assert any(r.negated for r in said)
    assert {r.relation for r in said if len(r.grounds) > 1} >= {"between", "at", "on"}


@pytest.mark.parametrize(("annotated", "relation"), SAID)
def test_what_is_said_is_true(annotated, relation):
    """Within reach of its grounds, and on the side of them that the word names."""
    city = load_map(annotated.map)
    record = RELATIONS[relation.relation]
    kind = record.relation_class
    for ground in relation.grounds:
        distance, bearing = seen_from(annotated, relation, ground)
        if relation.negated:
            assert distance > 0
        elif kind == "contact":
            assert distance <= 10
        else:
            # A word of direction may be said of a whole street from far along it.
            assert distance <= 30
        if record.is_compass:
            assert math.cos(bearing - math.radians(COMPASS_DEG[kind])) > 0.4
        if record.needs_frame:
            front = math.pi / 2
            if kind in ("front", "behind"):
                front = city.bearing_to_nearest_path(ground)
            assert math.cos(bearing - front - math.radians(OFFSET_DEG[kind])) > 0.4


@pytest.mark.parametrize(
    ("annotated", "relation"), [p for p in SAID if p.values[1].relation == "between"]
)
def test_between_lies_between(annotated, relation):
    """The nearest points of the grounds are seen in opposite directions from the true place."""
    city = load_map(annotated.map)
    place = annotated.targets[relation.figure]
    here = shapely.Point(place.x_m, place.y_m)
    lines = [shapely.shortest_line(here, city.footprint(g)) for g in relation.grounds]
    (one, other) = (np.subtract(*shapely.get_coordinates(line)) for line in lines)
    # Zero where it stands at the very wall of one of them.
    assert one @ other <= -0.25 * np.linalg.norm(one) * np.linalg.norm(other)


def test_sloop_m4_ranks_the_true_cells_high():
    """Half of the true cells are among the 40 most probable of 1681, given the gold relations."""
    ranks = []
    for annotated in SCENES:
        said = Description(annotated.text, annotated.map, annotated.objects, annotated.relations)
        posterior, _ = infer_description(said, load_map(annotated.map), model="sloop-m4")
        for target, place in annotated.targets.items():
            belief = posterior.belief(target)
            here = belief[place.cell]
            ranks.append((belief > here).sum() + ((belief == here).sum() - 1) / 2)
    assert np.median(ranks) < 40
