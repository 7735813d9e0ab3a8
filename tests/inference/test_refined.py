from __future__ import annotations

import numpy as np
import pytest
import shapely
from support.made_county import made_county

import sloop_ppl as sloop
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference import infer_description, infer_refined
from sloop_ppl.language import Description, SpatialRelation, TargetObject
from sloop_ppl.maps import Grid, UnevenGrid
from sloop_ppl.maps.uneven_grid import uneven_fields


@pytest.fixture(scope="module")
def county():
    return made_county(1000, 300)


def said(city, *phrases):
    relations = tuple(SpatialRelation("Car", word, grounds) for word, *grounds in phrases)
    return Description("", city.name, (TargetObject("Car"),), relations)


PHRASES = [
    [("near", "Hall7")],
    [("behind", "Hall7"), ("left", "Hall8"), ("front", "Hall9")],
    [("on", "1Street"), ("near", "3Avenue")],
    [("between", "Hall3", "Hall5")],
    [("north", "Hall7"), ("east", "Hall2")],
    [("across", "2Avenue")],
]


@pytest.mark.parametrize("phrases", PHRASES, ids=lambda phrases: " ".join(p[0] for p in phrases))
def test_it_is_near_the_belief_on_all_cells(county, phrases):
    description = said(county, *phrases)
    whole = infer_description(description, county)[0].belief("Car")
    refined = infer_refined(description, county)
    belief = refined.belief("Car")
    assert belief.shape == whole.shape
    assert belief.sum() == pytest.approx(1)
    assert 0.5 * np.abs(belief - whole).sum() < 0.01
    assert refined.unresolved < 0.01
    assert refined.grid.size < county.grid.size / 2


def test_what_is_left_unresolved_goes_down_on_demand(county):
    description = said(county, ("near", "3Avenue"))
    whole = infer_description(description, county)[0].belief("Car")
    apart = [
        0.5 * np.abs(infer_refined(description, county, unresolved=u).belief("Car") - whole).sum()
        for u in (0.05, 0.004, 0.0005)
    ]
    assert apart[0] > apart[1] > apart[2]
    assert apart[2] < 0.001


def test_other_latents_are_those_of_the_whole_map(county):
    description = said(county, *PHRASES[1])
    whole = infer_description(description, county)[0]
    blocks = infer_refined(description, county).blocks
    component = whole.component("Car")
    assert blocks.component("Car") == pytest.approx(component, abs=5e-3)
    for lapse, wanted in zip(blocks.lapses("Car"), whole.lapses("Car"), strict=True):
        assert lapse.p == pytest.approx(wanted.p, abs=5e-3)


def test_doubts_of_reading_are_summed_out_too():
    city = sloop.load_map("cleveland")
    description = sloop.parse("i think the red bike is near ivy or behind velvet dog", city)
    whole = infer_description(description, city)[0].belief("RedBike")
    belief = infer_refined(description, city).belief("RedBike")
    assert 0.5 * np.abs(belief - whole).sum() < 0.01


def test_a_window_is_a_map_to_search(county):
    refined = infer_refined(said(county, *PHRASES[1]), county)
    part, belief = refined.window("Car", mass=0.8)
    assert belief.shape == part.grid.shape
    assert belief.sum() == pytest.approx(1)
    whole = refined.belief("Car")
    row, col = np.unravel_index(belief.argmax(), belief.shape)
    x, y = part.grid.centre_of(int(row), int(col))
    assert county.grid.centre_of(*np.unravel_index(whole.argmax(), whole.shape)) == (
        pytest.approx(x),
        pytest.approx(y),
    )
    episode = sloop.planning.run_search(
        {"Car": belief}, part, {"Car": (x, y)}, rng=np.random.default_rng(0)
    )
    assert episode.found_targets == ("Car",)


def test_a_window_that_would_be_too_large_is_refused(county):
    refined = infer_refined(said(county, ("on", "1Street")), county)
    with pytest.raises(InputError, match="m apart; expected 500 at most"):
        refined.window("Car", most_m=500)
    with pytest.raises(UnknownName, match="Bus"):
        refined.belief("Bus")


def test_millions_of_cells_are_no_more_work_than_what_is_mentioned():
    city = made_county(10_000, 2000)
    refined = infer_refined(said(city, *PHRASES[1]), city)
    assert city.grid.size > 16_000_000
    assert refined.grid.size < 400_000
    assert refined.unresolved < 0.01
    assert "16008001" not in repr(refined)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"model": "sloop-m4"}, "no product of phrases alone"),
        ({"unresolved": 0.0}, "expected a total variation above 0"),
    ],
)
def test_what_it_cannot_is_said_in_one_line(county, change, message):
    with pytest.raises(InputError, match=message):
        infer_refined(said(county, *PHRASES[0]), county, **change)


def test_small_cells_and_related_targets_are_refused(county):
    with pytest.raises(InputError, match=r"cells of 2.5 m"):
        infer_refined(said(county, *PHRASES[0]), made_county(100, 10, cell_m=2.5))
    targets = (TargetObject("Car"), TargetObject("Bus"))
    related = Description("", county.name, targets, (SpatialRelation("Car", "near", ("Bus",)),))
    with pytest.raises(InputError, match="relates targets to each other"):
        infer_refined(related, county)


def test_blocks_of_one_cell_are_the_cells(county):
    even = made_county(200, 10).grid
    edges = tuple(range(even.n_cols + 1))
    grid = UnevenGrid(*even.extent_m, col_edges=edges, row_edges=edges)
    np.testing.assert_allclose(grid.x_m, even.x_m)
    np.testing.assert_allclose(grid.y_m, even.y_m)
    assert grid.size == even.size
    city = made_county(200, 10)
    for hall in ("Hall1", "0Street"):
        wanted, found = city.fields(hall), city.with_grid(grid).fields(hall)
        assert (found.cells == wanted.cells).all()
        np.testing.assert_allclose(found.distance_m, wanted.distance_m, atol=1e-9)


def test_fields_of_blocks_are_of_their_centres():
    city = made_county(200, 10)
    grid = UnevenGrid(*city.grid.extent_m, col_edges=(0, 3, 10, 81), row_edges=(0, 40, 81))
    fields = uneven_fields(grid, city.footprint("Hall1"))
    assert fields.distance_m.shape == (2, 3)
    assert grid.counts.sum() == city.grid.size
    assert grid.spread(grid.counts / grid.counts.sum()).max() == pytest.approx(1 / 81**2)
    assert isinstance(grid.even, Grid)
    assert grid.cell_at(*city.grid.centre_of(45, 5)) == (1, 1)


def test_it_is_summed_up_as_its_table_is(county):
    refined = infer_refined(said(county, ("near", "Hall7")), county)
    belief, grid = refined.belief("Car"), county.grid
    x, y = grid.x_m, grid.y_m
    cells = belief.reshape(-1)
    distance = np.hypot(*np.meshgrid(x - 100.0, y + 50.0))
    assert refined.expected("Car") == pytest.approx(
        (float((belief.sum(0) * x).sum()), float((belief.sum(1) * y).sum()))
    )
    assert belief[grid.cell_at(*refined.mode("Car"))] == cells.max()
    assert refined.entropy("Car") == pytest.approx(-(cells[cells > 0] @ np.log(cells[cells > 0])))
    assert refined.expected_distance("Car", (100.0, -50.0)) == pytest.approx(
        float((belief * distance).sum())
    )
    east = shapely.box(0.0, -1e4, 1e4, 1e4)  # its border runs through the middle of a column
    share = np.where(x > 0, 1.0, np.where(x == 0, 0.5, 0.0))
    assert refined.probability_in("Car", east) == pytest.approx(float((belief * share).sum()))
    region = refined.hpd("Car", 0.5)
    assert belief[region].sum() >= 0.5 > belief[region].sum() - belief[region].min()
