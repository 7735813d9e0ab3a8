"""Predictions of the shipped networks, and weights that are refused."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
import torch
from safetensors import safe_open
from safetensors.torch import load_file, save_file
from support.facing_block import facing_town

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import CityMap, Grid, Landmark, load_map
from sloop_ppl.models import GroundedRelation
from sloop_ppl.models.frames import (
    FRAME_PREDICTORS,
    FrameNetwork,
    LearnedFrames,
    NetworkShape,
    TrainedFrames,
    choices_of,
    frame_predictor,
    load_weights,
    log_density,
    predict_frames,
    save_weights,
    shipped_weights,
)
from sloop_ppl.models.frames.learned import _merged_first, _sureness
from tests.scenes import point_city, symmetric_grid

NAMES = ("ego-ctx", "ctx", "ego")


def front_of(city, name, predictor="ego-ctx"):
    return FRAME_PREDICTORS[predictor](GroundedRelation("front", (name,), city))


@pytest.mark.parametrize("name", NAMES)
def test_shipped_weights_say_how_they_were_made_and_are_small(name):
    path = shipped_weights(name)
    about = load_weights(path).about
    assert path.stat().st_size < 330_000
    assert about["name"] == name
    assert about["command"].startswith("sloop frames train --maps DIR")
    assert "ODbL" in about["data"]
    assert "austin" not in about["trained_on"]
    assert "citysim" not in about["trained_on"]


@pytest.mark.parametrize("name", ["ego-ctx", "ego"])
def test_a_quarter_turn_of_the_map_turns_the_prediction(name):
    """The mixture of a turned map is the turned mixture, to rounding of the drawing.

    Not so where the picture is not centred: its tiles are laid from the north-west corner.
    """
    straight, turned = facing_town(), facing_town(turn_rad=math.pi / 2)
    one, two = (front_of(city, "House1n5", name).binned(24) for city in (straight, turned))
    assert 0.5 * np.abs(np.roll(one, 6) - two).sum() < 0.1


def test_the_order_in_which_landmarks_are_asked_for_is_irrelevant():
    city = load_map("denver")
    ids = [b.id for b in city.of_kind("building")][:6]
    trained = load_weights(shipped_weights("ego-ctx"))
    forward = predict_frames(trained, city, ids)
    backward = predict_frames(trained, city, ids[::-1])[::-1]
    for one, two in zip(forward, backward, strict=True):
        np.testing.assert_allclose(one.binned(24), two.binned(24), atol=1e-5)


def test_many_predictions_are_those_made_one_by_one():
    """More than are predicted at once: houses, a poi, streets and what has no surroundings."""
    denver = load_map("denver")
    far = Landmark("Far", "building", shapely.box(4000, 4000, 4010, 4020))
    city = CityMap("more", denver.grid, (*denver.landmarks, far))
    ids = [landmark.id for landmark in city.landmarks]
    trained = load_weights(shipped_weights("ego-ctx"))
    many = predict_frames(trained, city, ids * 6)
    for name, *found in zip(ids, many, many[-len(ids) :], strict=False):
        (one,) = predict_frames(trained, city, [name])
        for front in found:
            np.testing.assert_allclose(front.binned(24), one.binned(24), atol=1e-5)
    assert predict_frames(trained, city, []) == []


def by_hand(network, pictures, bearing, features, there):
    """Return the densities, on 360 angles, of the four turned pictures turned back."""
    angle = torch.arange(360) * (math.pi / 180)
    turns = []
    for turn in range(4):
        seen = torch.rot90(pictures, -turn, (-2, -1))
        quarter = turn * math.pi / 2
        told = network(seen, bearing + quarter, features, there)
        turns.append([log_density(told, (a + quarter).expand(len(seen))).exp() for a in angle])
    return torch.tensor([[t.tolist() for t in turn] for turn in turns]).mean(0)


@pytest.mark.parametrize(
    "shape",
    [
        NetworkShape(),
        NetworkShape(streets=False),
        NetworkShape(angle=True, streets=False, greys=True),
        NetworkShape(view="ego"),
    ],
)
def test_the_average_over_quarter_turns_is_that_made_by_hand(shape):
    torch.manual_seed(0)
    network = FrameNetwork(shape).eval()
    pictures, features = torch.rand(40, 4, 28, 28), torch.rand(40, 3, 16)
    bearing, there = 6 * torch.rand(40, 3), torch.arange(3) < torch.randint(4, (40, 1))
    with torch.inference_mode():
        expected = by_hand(network, pictures, bearing, features, there)
        found = network.averaged(pictures, bearing, features, there)
        angle = torch.arange(360) * (math.pi / 180)
        made = torch.stack([log_density(found, a.expand(40)).exp() for a in angle])
    torch.testing.assert_close(made, expected, atol=1e-4, rtol=1e-4)


def test_merged_parts_keep_their_weight_and_their_middle():
    mean = np.tile([-0.4, 0.4, 2.0], (3, 1))
    weight = np.array([[0.3, 0.3, 0.2], [0.5, 0.0, 0.2], [0.0, 0.0, 0.9]])
    merged = _merged_first(2, mean, np.full((3, 3), 50.0), weight)
    np.testing.assert_allclose(merged[0], [[2.0, 0.0], [2.0, -0.4], [2.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(merged[2], [[0.2, 0.6], [0.2, 0.5], [0.9, 0.0]])
    assert 5 < merged[1][0, 1] < 10  # R is about cos 0.4
    assert merged[1][1, 1] == pytest.approx(50, rel=0.02)


def test_corner_buildings_have_two_fronts_and_others_one():
    """Facts of the bundled map: these two stand at a corner, Ball Building in a row."""
    city = load_map("cleveland")
    for corner in ("WaringBlock", "GrandArcade"):
        first, second = front_of(city, corner).parts[:2]
        assert second.weight > 0.2
        gap = abs(math.remainder(first.mean_rad - second.mean_rad, 2 * math.pi))
        assert gap == pytest.approx(math.pi / 2, abs=0.3)
    assert front_of(city, "BallBuilding").parts[0].weight > 0.8


@pytest.mark.parametrize("name", NAMES)
def test_without_streets_nothing_is_known(name):
    grid = Grid.square(200.0)
    alone = CityMap("field", grid, (Landmark("Barn", "building", shapely.box(-9, -5, 9, 5)),))
    assert front_of(alone, "Barn", name).lapse == 1.0


@pytest.mark.parametrize("name", NAMES)
def test_near_the_edge_of_the_map_the_lapse_is_larger(name):
    """The same block, once whole and once cut off 12 m beside the house."""
    landmarks = (
        Landmark("House", "building", shapely.box(-8, -8, 8, 8)),
        Landmark("Main", "street", shapely.LineString([(-8, -30), (8, -30)]), "Main Street"),
    )
    whole = CityMap("whole", Grid(-100, -100, 100, 100, 5.0), landmarks)
    cut = CityMap("cut", Grid(-12, -100, 188, 100, 5.0), landmarks)
    if name == "ctx":
        cut = CityMap("cut", replace(whole.grid, west_m=-12.0), landmarks)
    assert front_of(cut, "House", name).lapse > front_of(whole, "House", name).lapse + 0.05


def test_in_the_middle_of_a_map_no_direction_is_unseen():
    landmarks = (
        Landmark("House", "building", shapely.box(-8, -8, 8, 8)),
        Landmark("Main", "street", shapely.LineString([(-8, -30), (8, -30)]), "Main Street"),
    )
    whole = CityMap("whole", Grid(-100, -100, 100, 100, 5.0), landmarks)
    assert _sureness(whole, ["House"], choices_of(whole, ["House"])) == 1.0
    cut = CityMap("cut", Grid(-100, -100, 10, 100, 5.0), landmarks)
    beyond = 2 * math.acos(10 / 40) / (2 * math.pi)  # directions that end before 40 m
    unsure = 1 - 0.5 * beyond
    assert _sureness(cut, ["House"], choices_of(cut, ["House"])) == pytest.approx(unsure, abs=0.02)


@pytest.mark.parametrize("name", NAMES)
def test_a_landmark_that_reaches_beyond_the_map_is_no_trouble(name):
    grid = Grid.square(200.0)
    landmarks = (
        Landmark("Corner", "building", shapely.box(90, 90, 130, 130)),
        Landmark("Main", "street", shapely.LineString([(-99, 80), (99, 80)]), "Main Street"),
    )
    front = front_of(CityMap("edge", grid, landmarks), "Corner", name)
    assert front.binned(24).sum() == pytest.approx(1)


def test_a_street_faces_both_ways_and_a_point_is_less_sure_than_a_house():
    grid = Grid.square(200.0)
    street = Landmark("Main", "street", shapely.LineString([(-99, -20), (99, -20)]), "Main Street")
    house = Landmark("Thing", "building", shapely.box(-8, -8, 8, 8))
    point = Landmark("Thing", "poi", shapely.Point(0, 0))
    with_house, with_point = (CityMap("m", grid, (street, thing)) for thing in (house, point))
    both = front_of(with_house, "Main")
    assert sorted(p.mean_rad for p in both.parts) == pytest.approx([-math.pi / 2, math.pi / 2])
    assert front_of(with_point, "Thing").lapse > 0.25


def test_a_poi_faces_as_the_building_it_stands_in():
    city = load_map("cleveland")
    x, y = city.centroid("VelvetDog")
    house, _ = city.nearest(x, y, city.of_kind("building"))
    assert front_of(city, "VelvetDog").modes() == front_of(city, house.id).modes()


def test_a_predictor_is_found_by_name_or_by_the_path_of_its_weights():
    path = shipped_weights("ego")
    assert frame_predictor("ego") is FRAME_PREDICTORS["ego"]
    assert frame_predictor(path) == LearnedFrames(path)
    with pytest.raises(UnknownName, match="did you mean 'ego-ctx'"):
        frame_predictor("ego-ctxx")


def test_weights_that_were_saved_are_read_again(tmp_path):
    network = FrameNetwork(NetworkShape(channels=(4, 8), hidden=(8, 8)))
    path = tmp_path / "w.safetensors"
    save_weights(TrainedFrames(network, {"name": "mine"}), path)
    again = load_weights(path)
    assert again.about["name"] == "mine"
    assert again.network.shape == network.shape
    for one, two in zip(network.parameters(), again.network.parameters(), strict=True):
        torch.testing.assert_close(one, two)
    first = path.read_bytes()
    save_weights(again, path)
    assert path.read_bytes() == first


def rewritten(tmp_path, **told):
    """Return a copy of the shipped weights with other metadata; None leaves an entry out."""
    source = shipped_weights("ego")
    with safe_open(source, framework="pt") as file:
        metadata = json.loads(file.metadata()["sloop_frames"]) | told
    path = tmp_path / "other.safetensors"
    kept = {k: v for k, v in metadata.items() if v is not None}
    save_file(load_file(source), path, {"sloop_frames": json.dumps(kept)})
    return path


def test_weights_of_another_version_are_named_and_refused(tmp_path):
    with pytest.raises(InputError) as refused:
        load_weights(rewritten(tmp_path, version="sloop-frames 0"))
    assert "are of version 'sloop-frames 0'; expected 'sloop-frames 1'" in str(refused.value)
    assert "sloop frames train" in str(refused.value)
    with pytest.raises(InputError, match="are of version 'none'"):
        load_weights(rewritten(tmp_path, version=None))


def test_weights_that_do_not_fit_or_are_none_are_refused(tmp_path):
    shape = {"view": "ego", "channels": [8, 16], "streets": False}
    with pytest.raises(InputError, match="do not fit their network"):
        load_weights(rewritten(tmp_path, shape=shape))
    with pytest.raises(InputError, match="do not fit their network"):
        load_weights(rewritten(tmp_path, shape={"depth": 3}))
    text = tmp_path / "text.safetensors"
    text.write_text("no weights")
    with pytest.raises(InputError, match="are no safetensors file"):
        load_weights(text)
    with pytest.raises(InputError, match="do not exist"):
        load_weights(tmp_path / "missing.safetensors")
    with pytest.raises(InputError, match="do not exist"):
        frame_predictor(tmp_path / "missing.safetensors")


def test_weights_with_nan_are_refused(tmp_path):
    trained = load_weights(shipped_weights("ego"))
    with torch.no_grad():
        next(trained.network.parameters())[0] = math.nan
    path = tmp_path / "nan.safetensors"
    save_weights(trained, path)
    with pytest.raises(InputError, match="hold NaN or infinite numbers; train them again"):
        load_weights(path)


def test_an_address_tells_the_front_where_the_map_knows_it():
    town = facing_town()
    front = front_of(town, "House1n5", "address")
    assert front.modes() == (pytest.approx(math.pi / 2),)
    assert front.lapse == FRAME_PREDICTORS["address"].lapse
    lonely = point_city(symmetric_grid(21), Pole=(0.0, 0.0))
    assert front_of(lonely, "Pole", "address") == front_of(lonely, "Pole", "nearest-street")


def test_random_fronts_differ_from_building_to_building_and_stay():
    town = facing_town()
    first = [front_of(town, b.id, "random").modes()[0] for b in town.of_kind("building")]
    again = [front_of(town, b.id, "random").modes()[0] for b in town.of_kind("building")]
    assert first == again
    assert abs(np.exp(1j * np.array(first)).mean()) < 0.45  # P < 1e-4 if they are uniform, n = 48
