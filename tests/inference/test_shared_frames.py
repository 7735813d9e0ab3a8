"""Frames that one speaker shares between phrases and targets."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.inference import infer_description
from sloop_ppl.models import Component, PredictedSpread
from tests.mixture import MIXTURE
from tests.scenes import house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(15), street_y=30.0)
# A nearly flat prior over the front, so that sharing it matters.
OWN = replace(
    MIXTURE,
    components=(Component("product"),),
    frame_prior=PredictedSpread(kappa=0.5, lapse=0.0, absolute=0.0),
)
SHARED = replace(OWN, shared_frames=True)
TWO = said(
    relation("front", "House", figure="A"),
    relation("behind", "House", figure="B"),
    targets=("A", "B"),
)


def seen_at(x, y):
    table = np.full(CITY.grid.shape, -np.inf)
    table[CITY.grid.cell_at(x, y)] = 0.0
    return table


def north_share(posterior, target):
    belief = posterior.belief(target)
    return belief[8:].sum() / (belief[8:].sum() + belief[:7].sum())


def test_finding_one_car_reveals_the_frame_and_the_other_cars_place():
    posterior, _ = infer_description(TWO, CITY, SHARED)
    found = posterior.condition({"A": seen_at(0.0, -15.0)})  # in front: so it faces south
    assert north_share(posterior, "B") < 0.5  # the street lies north, behind is south
    assert north_share(found, "B") > 0.8
    (front,) = found.frames("B")
    assert math.cos(front.mean_rad + math.pi / 2) > 0.9
    assert posterior.log_evidence > found.log_evidence


def test_without_sharing_the_other_car_does_not_move():
    posterior, _ = infer_description(TWO, CITY, OWN)
    found = posterior.condition({"A": seen_at(0.0, -15.0)})
    np.testing.assert_allclose(found.belief("B"), posterior.belief("B"), atol=1e-14)


def test_sharing_is_the_sum_over_fronts_by_brute_force():
    """Fix the front at each angle, infer without sharing, and mix by evidence."""
    from sloop_ppl.models import FrameDistribution, FramePart, ground_relations

    sensed = {"A": np.log(np.random.default_rng(0).uniform(0.1, 1, CITY.grid.shape))}
    got, _ = infer_description(TWO, CITY, SHARED)
    got = got.condition(sensed)
    (term,) = ground_relations(TWO.about("A"), CITY)
    angles, mass = SHARED.frame_prior(term).bins(72)
    log_w, tables = [], []
    for angle, p in zip(angles, mass, strict=True):

        def fixed(_, angle=angle):
            return FrameDistribution((FramePart(angle, math.inf),))

        # The phrase is normalised under its frame's prior, not under the fixed front.
        raw = replace(OWN, frame_prior=fixed, normalisation="truth")
        one, _ = infer_description(TWO, CITY, raw)
        one = one.condition(sensed)
        log_w.append(one.log_evidence + math.log(p))
        tables.append({t: one.belief(t) for t in ("A", "B")})
    weights = np.exp(np.array(log_w) - max(log_w))
    weights /= weights.sum()
    for target in ("A", "B"):
        expected = sum(w * t[target] for w, t in zip(weights, tables, strict=True))
        np.testing.assert_allclose(got.belief(target), expected, atol=1e-9)


def test_phrases_of_one_target_share_a_front_too():
    """In front and to the left of one house: the shared front couples the two phrases."""
    what = said(relation("front", "House", figure="A"), relation("left", "House", figure="A"),
                targets=("A",))  # fmt: skip
    own, _ = infer_description(what, CITY, OWN)
    shared, _ = infer_description(what, CITY, SHARED)
    assert 0.5 * np.abs(own.belief("A") - shared.belief("A")).sum() > 0.02
    assert shared.component("A") == pytest.approx({"product": 1.0})


def test_the_evidence_is_the_sum_over_fronts_by_brute_force():
    """Each phrase is divided by its sum over the map, averaged over fronts."""
    from sloop_ppl.models import FrameDistribution, FramePart, ground_relations

    (term,) = ground_relations(TWO.about("A"), CITY)
    raw = replace(OWN, normalisation="truth")
    alone = [said(*TWO.about(target), targets=(target,)) for target in ("A", "B")]
    totals = dict.fromkeys(range(3), -math.inf)
    for angle, p in zip(*SHARED.frame_prior(term).bins(72), strict=True):
        front = FrameDistribution((FramePart(angle, math.inf),))
        fixed = replace(raw, frame_prior=lambda _, front=front: front)
        for k, what in enumerate((TWO, *alone)):
            given_front = infer_description(what, CITY, fixed)[0].log_evidence
            totals[k] = np.logaddexp(totals[k], given_front + math.log(p))
    expected = totals[0] - totals[1] - totals[2] - 2 * math.log(CITY.grid.size)
    assert infer_description(TWO, CITY, SHARED)[0].log_evidence == pytest.approx(expected, abs=1e-9)


def test_a_coupled_posterior_survives_saving(tmp_path):
    from sloop_ppl.inference import Posterior
    from sloop_ppl.maps import load_map
    from sloop_ppl.models import PRESETS

    city = load_map("cleveland")
    PRESETS.add("test-shared", replace(SHARED, name="test-shared"))
    try:
        what = said(
            relation("front", "HoytBlock", figure="A"),
            relation("behind", "HoytBlock", figure="B"),
            relation("near", "HoytBlock", figure="B"),
            targets=("A", "B"),
        )
        before, _ = infer_description(what, city, "test-shared")
        before.save(tmp_path / "p.nc")
        after = Posterior.load(tmp_path / "p.nc")
        sensed = {"A": np.where(np.arange(41)[:, None] > 20, 0.0, -np.inf) + np.zeros((41, 41))}
        for target in ("A", "B"):
            np.testing.assert_allclose(
                after.condition(sensed).belief(target), before.condition(sensed).belief(target)
            )
    finally:
        PRESETS._entries.pop("test-shared")


def test_two_coupled_descriptions_are_enumerated_jointly():
    first, _ = infer_description(TWO, CITY, SHARED)
    second = first.update(TWO)
    other = infer_description(TWO, CITY, SHARED)[0].update(TWO)
    np.testing.assert_allclose(second.belief("A"), other.belief("A"))
    squared = first.belief("A") ** 2
    assert 0.5 * np.abs(second.belief("A") - squared / squared.sum()).sum() < 0.2
    with pytest.raises(InputError, match="373248 joint settings; at most 5184"):
        second.update(TWO)
