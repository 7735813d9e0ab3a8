"""Training of frame networks: labels, examples, and what is learnt from them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
import torch
from support.facing_block import facing_rad, facing_town

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference._frame_examples import (
    FrameLabel,
    address_labels,
    entrance_labels,
    frame_examples,
    joined,
    maps_of_folder,
)
from sloop_ppl.inference._frame_training import (
    RECIPES,
    Recipe,
    squared_angle,
    train_frames,
    train_on_maps,
    training_command,
)
from sloop_ppl.maps import CityMap, Grid, Landmark, write_map
from sloop_ppl.models import FRAME_PREDICTORS, GroundedRelation
from sloop_ppl.models.frames import FramePart, Outputs, TrainedFrames, log_density, predict_frames

SMALL = Recipe(epochs=4, batch=32)
TOWNS = {f"town{i}": facing_town(f"town{i}", turn_rad=0.4 * i, seed=i) for i in range(2)}


def rng():
    return np.random.default_rng(0)


def examples_of(city, **options):
    return frame_examples(city, address_labels(city), drawings=2, rng=rng(), **options)


def test_labels_are_the_directions_to_the_streets_of_addresses():
    town = facing_town()
    labels = {label.building: label.frame_angle_rad for label in address_labels(town)}
    assert labels == pytest.approx(facing_rad(town))


def test_an_address_whose_street_is_far_tells_nothing():
    """The wall is 55 m from the street in one place, 65 m in the other."""
    grid = Grid.square(400.0)
    street = Landmark("Far", "street", shapely.LineString([(-199, 0), (199, 0)]), "Far Street")
    found = {}
    for wall in (55, 65):
        box = shapely.box(-5, wall, 5, wall + 10)
        house = Landmark("H", "building", box, properties={"addr:street": "Far St"})
        found[wall] = address_labels(CityMap("m", grid, (street, house)))
    assert [label.frame_angle_rad for label in found[55]] == pytest.approx([-math.pi / 2])
    assert found[65] == []


def test_main_entrances_are_labels_of_their_own():
    grid = Grid.square(200.0, centre=(10.0, 20.0))
    lon, lat = grid.to_lonlat(5.0, 0.0)
    door = {"entrance": "main", "lonlat": [float(lon), float(lat)]}
    box = shapely.box(-5, -5, 5, 5)
    house = Landmark("H", "building", box, properties={"entrances": [door]})
    assert entrance_labels(CityMap("m", grid, (house,))) == [FrameLabel("H", pytest.approx(0.0))]


def test_a_batch_turns_pictures_directions_and_labels_alike():
    """The label is always the direction to one of the streets, and the picture shows it there."""
    examples = examples_of(facing_town())
    batch = examples.batch(torch.arange(len(examples)), torch.Generator().manual_seed(3))
    gap = torch.cos(batch.bearing_rad - batch.frame_angle_rad[:, None])
    assert torch.where(batch.there, gap, -1).max(1).values.min() > 1 - 1e-5
    at = torch.arange(28) - 13.5
    rows, cols = torch.meshgrid(at, at, indexing="ij")
    ahead = torch.cos(torch.atan2(rows, cols) - batch.frame_angle_rad[:, None, None]) > 0.9
    near = torch.hypot(rows, cols) < 9
    streets = batch.pictures[:, 1]
    in_front = (streets * (ahead & near)).sum((1, 2))
    behind = (streets * (ahead.flip(1, 2) & near)).sum((1, 2))
    assert (in_front > behind).float().mean() > 0.95


@pytest.mark.parametrize("view", ["ctx", "ego"])
def test_pictures_of_every_view_hold_their_landmark(view):
    examples = examples_of(facing_town(blocks=1), view=view)
    assert (examples.pictures[:, :, 0].flatten(2).max(2).values > 60).all()


def test_joined_examples_keep_all_streets():
    few = examples_of(facing_town(blocks=1))
    many = examples_of(facing_town(blocks=3))
    both = joined([few, many])
    assert len(both) == len(few) + len(many)
    assert both.there[: len(few)].sum() == few.there.sum()
    with pytest.raises(InputError, match="No building tells which way it faces"):
        joined([])


def test_the_log_score_is_that_of_a_mixture_by_hand():
    outputs = Outputs(
        torch.tensor([[0.3, 2.0]]),
        torch.tensor([[4.0, 30.0]]),
        torch.log(torch.tensor([[0.5, 0.3, 0.2]])),
    )
    angle = np.array([1.1])
    expected = (
        0.5 * np.exp(FramePart(0.3, 4.0).log_density(angle))
        + 0.3 * np.exp(FramePart(2.0, 30.0).log_density(angle))
        + 0.2 / (2 * math.pi)
    )
    found = log_density(outputs, torch.from_numpy(angle).float())
    assert found.item() == pytest.approx(math.log(expected[0]), abs=1e-5)


@pytest.mark.parametrize(
    ("predicted", "label", "squared"),
    [(0.1, 0.4, 0.09), (3.1, -3.1, (2 * math.pi - 6.2) ** 2), (0.0, math.pi, math.pi**2)],
)
def test_the_papers_loss_is_the_squared_angle_round_the_circle(predicted, label, squared):
    outputs = Outputs(torch.tensor([[predicted]]), torch.ones(1, 1), torch.zeros(1, 2))
    assert squared_angle(outputs, torch.tensor([label])).item() == pytest.approx(squared, abs=1e-4)


def test_the_papers_recipe_is_the_papers():
    recipe = RECIPES["paper"]
    assert recipe.learning_rate == 1e-5
    assert recipe.patience == 20
    assert recipe.loss == "squared-angle"
    assert 25 * recipe.shape.channels[1] == 800
    assert recipe.shape.view == "ego-ctx"
    assert recipe.shape.greys


@pytest.mark.slow
def test_a_network_learns_which_street_counts_and_is_sure_of_it():
    """Trained on one town it knows another, turned one, where the nearest way is often wrong."""
    recipe = replace(SMALL, epochs=25, patience=25)
    network, info = train_frames(examples_of(TOWNS["town0"]), recipe, rng=rng())
    assert info.best == min(info.losses)
    assert info.losses[-1] < info.losses[0] - 1
    town = TOWNS["town1"]
    labels = address_labels(town)
    made = predict_frames(TrainedFrames(network), town, [label.building for label in labels])
    right = [abs(math.remainder(front.modes()[0] - label.frame_angle_rad, 2 * math.pi)) < 0.3
             for front, label in zip(made, labels, strict=True)]  # fmt: skip
    rule = FRAME_PREDICTORS["nearest-street"]
    ruled = [
        abs(math.remainder(
            rule(GroundedRelation("front", (one.building,), town)).modes()[0] - one.frame_angle_rad,
            2 * math.pi,
        )) < 0.3
        for one in labels
    ]  # fmt: skip
    assert np.mean(ruled) < 0.7
    assert np.mean(right) > 0.9


def test_the_papers_recipe_trains_and_knows_its_errors():
    recipe = replace(RECIPES["paper"], epochs=2)
    network, info = train_frames(examples_of(facing_town()), recipe, rng=rng())
    assert info.epochs == 2
    assert 0 < torch.sigmoid(network.angle_lapse) < 1
    (front,) = predict_frames(TrainedFrames(network), facing_town(), ["House1n5"])
    assert front.binned(24).sum() == pytest.approx(1)


def test_the_same_seed_gives_the_same_network_whatever_was_drawn_before():
    examples = examples_of(facing_town(blocks=2))
    recipe = replace(SMALL, epochs=2)
    torch.manual_seed(1)
    one, _ = train_frames(examples, recipe, rng=rng())
    torch.manual_seed(2)
    two, _ = train_frames(examples, recipe, rng=rng())
    for a, b in zip(one.parameters(), two.parameters(), strict=True):
        assert torch.equal(a, b)


def test_training_stops_when_there_is_no_gain():
    recipe = replace(SMALL, epochs=30, patience=2, learning_rate=0.0)
    _, info = train_frames(examples_of(facing_town(blocks=2)), recipe, rng=rng())
    assert info.epochs == 3


def test_nan_in_training_is_named():
    recipe = replace(SMALL, learning_rate=1e30)
    with pytest.raises(
        InputError, match=r"The loss is (nan|inf) in pass 1; expected a finite number"
    ):
        train_frames(examples_of(facing_town(blocks=2)), recipe, rng=rng())


def test_a_label_that_is_no_angle_is_named():
    with pytest.raises(InputError, match="The front of 'House0n0' on map 'town' is nan"):
        frame_examples(facing_town(), [FrameLabel("House0n0", math.nan)], rng=rng())


def test_a_handful_of_buildings_is_too_few():
    with pytest.raises(InputError, match="There are 12 labelled buildings to train on"):
        train_frames(examples_of(facing_town(blocks=1)), SMALL, rng=rng())


def test_weights_say_on_what_and_how_they_were_trained():
    told: list[str] = []
    trained, info = train_on_maps(
        TOWNS, "ego-ctx", epochs=1, command="this", rng=rng(), progress=told.append
    )
    assert trained.about["trained_on"] == "town0 (48), town1 (48)"
    assert trained.about["command"] == "this"
    assert info.examples + info.held_back == 96
    assert any("48 labelled buildings" in line for line in told)
    assert any("pass 1: loss" in line for line in told)
    with pytest.raises(UnknownName, match="Recipe 'egoctx' is unknown"):
        train_on_maps(TOWNS, "egoctx", rng=rng())


def test_the_command_is_told_as_it_was_given():
    assert training_command("ego", "a,b", None, 5, 3) == (
        "sloop frames train --maps DIR --recipe ego --leave-out a,b --patience 5 --seed 3 "
        "--out ego.safetensors"
    )


def test_maps_of_a_folder_are_read_by_name(tmp_path):
    for name in ("b", "a"):
        write_map(facing_town(name, blocks=1), tmp_path / f"{name}.geojson")
    assert list(maps_of_folder(tmp_path)) == ["a", "b"]
    assert list(maps_of_folder(tmp_path, leave_out=("a",))) == ["b"]
    with pytest.raises(InputError, match="Map 'c' to leave out is not in folder"):
        maps_of_folder(tmp_path, leave_out=("c",))
    (tmp_path / "a.osm").write_text("<osm/>")
    with pytest.raises(InputError, match="holds 'a' twice"):
        maps_of_folder(tmp_path)


def test_a_folder_without_maps_is_refused(tmp_path):
    with pytest.raises(InputError, match="holds no map; expected"):
        maps_of_folder(tmp_path)
    with pytest.raises(InputError, match="is no folder"):
        maps_of_folder(tmp_path / "none")
