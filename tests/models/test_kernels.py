"""Likelihoods worked out on paper, one or two values each."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import torch

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import CityMap, Grid, Landmark
from sloop_ppl.models import FrameDistribution, FramePart, ground_relations
from sloop_ppl.models.likelihoods import (
    AttentionVectorSumLikelihood,
    BoxLikelihood,
    NeuralLikelihood,
    StudentVonMisesLikelihood,
)
from tests.scenes import house_and_street, point_city, relation, symmetric_grid

CITY = point_city(symmetric_grid(21), Pole=(0.0, 0.0))
EAST = torch.tensor([0.0], dtype=torch.float64)


def term(word, city=CITY, ground="Pole"):
    return ground_relations((relation(word, ground),), city)[0]


def at(table, x, y, city=CITY):
    row, col = city.grid.cell_at(x, y)
    return float(table.reshape(city.grid.shape)[row, col].exp())


def test_students_kernel_and_von_mises():
    kernel = StudentVonMisesLikelihood(near_m=10.0, directed_m=10.0, tail=3.0, kappa_compass=2.0)
    near = kernel.log_g(term("near"), None)
    assert at(near, 0, 0) == 1
    assert at(near, 10, 0) == pytest.approx((1 + 1 / 3) ** -2)
    # Heavy: at five widths still (1 + 25 / 3)^-2 = .0115, where a Gaussian has 4e-6.
    assert at(near, 50, 0) == pytest.approx((28 / 3) ** -2)
    east = kernel.log_g(term("east"), EAST)[0]
    assert at(east, 0, 10) / at(east, 10, 0) == pytest.approx(math.exp(-2))


@pytest.mark.parametrize(("said_m", "width_m"), [(40.0, 10.0), (10.0, 5.0)])
def test_a_said_distance_is_a_ring_a_quarter_as_wide_and_no_narrower_than_contact(said_m, width_m):
    kernel = StudentVonMisesLikelihood(near_m=33.0, contact_m=5.0, tail=3.0)
    said = replace(relation("near", "Pole"), distance_m=said_m)
    (ring,) = ground_relations((said,), CITY)
    table = kernel.log_g(ring, None)
    assert at(table, said_m, 0) == 1
    assert at(table, 0, 0) == pytest.approx((1 + (said_m / width_m) ** 2 / 3) ** -2)
    learnt = replace(kernel, contact_m=torch.tensor(5.0, dtype=torch.float64)).log_g(ring, None)
    assert torch.allclose(learnt, table)


@pytest.mark.parametrize("number", ["kappa", "mean_rad", "weight"])
def test_the_closed_form_has_the_slope_of_its_values(number):
    """Numbers of a frame that is learnt: the gradient is that of central differences."""
    kernel, east = StudentVonMisesLikelihood(), term("front")

    def value(shift):
        numbers = {"mean_rad": 0.4, "kappa": 2.0, "weight": 0.7}
        numbers[number] = numbers[number] + shift
        parts = (FramePart(**numbers), FramePart(2.0, 1.0, 0.9 - numbers["weight"]))
        return kernel.log_marginal(east, FrameDistribution(parts, lapse=0.1))

    zero = torch.zeros((), dtype=torch.float64, requires_grad=True)
    value(zero)[7].backward()
    with torch.no_grad():
        step = torch.tensor(1e-5, dtype=torch.float64)
        slope = float(value(step)[7] - value(-step)[7]) / 2e-5
    assert float(zero.grad) == pytest.approx(slope, rel=1e-6)
    assert slope != 0


def test_the_closed_form_on_many_cells_is_the_one_on_few():
    """It is read off a table where there are more cells than 8192."""
    many, few = (point_city(symmetric_grid(n), Pole=(0.0, 0.0)) for n in (101, 31))
    frame = FrameDistribution((FramePart(0.4, 40.0, 0.7), FramePart(2.0, 0.0, 0.2)), lapse=0.1)
    kernel = StudentVonMisesLikelihood(kappa_frame=30.0)
    tables = [
        kernel.log_marginal(term("left", city), frame).reshape(city.grid.shape)
        for city in (many, few)
    ]
    assert torch.allclose(tables[0][35:66, 35:66], tables[1], atol=1e-9, rtol=0)


def test_a_street_has_widths_of_its_own():
    city = house_and_street(symmetric_grid(21), street_y=0.0)
    kernel = StudentVonMisesLikelihood(near_m=5.0, near_street_m=20.0, tail=3.0)
    far = at(kernel.log_g(term("near", city, "MainSt"), None), 0, 40, city)
    # Its cells reach to 5 m north of its middle.
    assert far == pytest.approx((1 + 35**2 / (3 * 20**2)) ** -2)


def test_north_of_a_street_is_north_of_its_nearest_part():
    """The published code asks the street's middle, which lies 45 m west of here."""
    city = house_and_street(symmetric_grid(21), street_y=0.0)
    north = torch.tensor([math.pi / 2], dtype=torch.float64)
    kernel = StudentVonMisesLikelihood()
    table = kernel.log_g(term("north", city, "MainSt"), north)[0]
    assert at(table, 45, 15, city) == pytest.approx(at(table, 0, 15, city))


def test_a_box_is_one_inside_and_its_floor_outside():
    box = BoxLikelihood(near_m=20.0, directed_m=20.0, half_angle_rad=math.pi / 4, floor=1e-6)
    near = box.log_g(term("near"), None)
    assert at(near, 20, 0) == 1
    assert at(near, 25, 0) == pytest.approx(1e-6)
    # A frame that may be anything: a quarter of the circle lies within 45 degrees of it.
    lapse = box.log_marginal(term("front"), FrameDistribution((), lapse=1.0))
    assert at(lapse, 10, 0) == pytest.approx(0.25, rel=1e-5)
    half = FrameDistribution((FramePart(0.0, math.inf, 0.5),), lapse=0.5)
    assert at(box.log_marginal(term("front"), half), 10, 0) == pytest.approx(0.625, rel=1e-5)


def test_attention_to_a_point_is_its_angle():
    kernel = AttentionVectorSumLikelihood(grazing_m=1.0, directed_m=10.0, tail=3.0)
    east = kernel.log_g(term("east"), EAST)[0]
    # Straight ahead at 10 m: the fall-off alone. At 45 degrees: half, at 90: the floors.
    assert at(east, 10, 0) == pytest.approx((4 / 3) ** -2, rel=1e-3)
    assert at(east, 10, 10) == pytest.approx((1 + 200 / 300) ** -2 / 2, rel=1e-3)
    assert at(east, 0, 10) < 1e-3


def test_attention_goes_to_the_near_end_of_a_long_ground():
    """East of the east end of a wall is east, although its centroid lies far to the south-west."""
    grid = Grid(-60, -60, 60, 60)
    import shapely

    wall = Landmark("Wall", "building", shapely.box(-50, -2, 0, 2))
    city = CityMap("wall", grid, (wall,))
    north = torch.tensor([math.pi / 2], dtype=torch.float64)
    narrow = AttentionVectorSumLikelihood(attention=0.1)
    wide = AttentionVectorSumLikelihood(attention=100.0)
    above_the_end = {
        name: at(kernel.log_g(term("north", city, "Wall"), north)[0], 0, 20, city)
        for name, kernel in (("narrow", narrow), ("wide", wide))
    }
    # Spread evenly, attention sees the cell at 50 degrees from the wall's middle.
    assert above_the_end["narrow"] > 1.5 * above_the_end["wide"]


def test_the_same_seed_is_the_same_network():
    one, same, other = (NeuralLikelihood(seed).log_g(term("near"), None) for seed in (0, 0, 1))
    assert torch.equal(one, same)
    assert not torch.equal(one, other)


def test_a_network_learns():
    """Told that what is "near" is 40 m away, it comes to think so."""
    network = NeuralLikelihood(seed=3).trainable()
    near = term("near")
    row, col = CITY.grid.cell_at(40, 0)
    optimiser = torch.optim.Adam(list(network.weights.values()), lr=0.01)
    scores = []
    for _ in range(300):
        log_g = network.log_g(near, None)
        score = log_g[row * CITY.grid.n_cols + col] - torch.logsumexp(log_g, 0)
        scores.append(float(score.detach()))
        optimiser.zero_grad()
        (-score).backward()
        optimiser.step()
    assert scores[-1] > scores[0] + 0.8
    assert (network.log_g(near, None) <= 0).all()


def test_weights_of_the_wrong_name_or_shape():
    with pytest.raises(UnknownName, match="Weight of NeuralLikelihood 'outt' is unknown"):
        NeuralLikelihood(weights={"outt": torch.zeros(16)})
    with pytest.raises(InputError, match=r"'out' .* has shape \(3,\); expected \(16,\)"):
        NeuralLikelihood(weights={"out": torch.zeros(3)})
    assert replace(NeuralLikelihood(), hidden=16).weights["out"].shape == (16,)
