"""The joint posterior against brute force over the program's own sites."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from pyro import poutine
from scipy.special import logsumexp

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference import infer_description
from sloop_ppl.inference.joint import LogTable, sum_product
from sloop_ppl.models import Component, PredictedSpread, build, preset
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(3, 20.0), house=(12.0, -7.0), street_y=20.0)
MODEL = replace(
    preset("bayes"),
    lapse=0.2,
    temper=0.0,
    frame_prior=PredictedSpread(),
    components=(Component("product", 0.7), Component("no-frame", 0.3, keep_frames=False)),
)
SPOKEN = said(relation("behind", "House"), relation("near", "MainSt"))
SITES = {
    f"{TARGET}/component": 2,
    f"{TARGET}/cell": 9,
    f"{TARGET}/frame_0": 72,
    f"{TARGET}/lapse_0": 2,
    f"{TARGET}/lapse_1": 2,
}


@pytest.fixture(scope="module")
def brute():
    """The log joint of every combination of values, from the trace of the conditioned program."""
    program = build(SPOKEN, CITY, MODEL, frame_bins=72)
    table = np.empty(tuple(SITES.values()))
    for values in itertools.product(*map(range, SITES.values())):
        data = {
            name: torch.tensor(float(v) if "lapse" in name else v)
            for name, v in zip(SITES, values, strict=True)
        }
        table[values] = float(
            poutine.trace(poutine.condition(program, data=data)).get_trace().log_prob_sum()
        )
    return np.exp(table - logsumexp(table))


@pytest.fixture(scope="module")
def joint():
    return infer_description(SPOKEN, CITY, MODEL)[0].joint


@pytest.mark.parametrize("names", [c for n in (1, 2, 3) for c in itertools.combinations(SITES, n)])
def test_every_marginal_and_joint_is_that_of_brute_force(brute, joint, names):
    others = tuple(i for i, name in enumerate(SITES) if name not in names)
    np.testing.assert_allclose(joint.probabilities(*names), brute.sum(others), atol=1e-9)


def test_conditionals_are_ratios_of_brute_force(brute, joint):
    given_ = {f"{TARGET}/lapse_0": True, f"{TARGET}/component": "product"}
    got = joint.probabilities(f"{TARGET}/cell", f"{TARGET}/frame_0", given=given_)
    part = brute[0, :, :, 1].sum(-1)
    np.testing.assert_allclose(got, part / part.sum(), atol=1e-9)


def test_the_order_of_names_is_the_order_of_axes(joint):
    one = joint.probabilities(f"{TARGET}/cell", f"{TARGET}/lapse_1")
    other = joint.probabilities(f"{TARGET}/lapse_1", f"{TARGET}/cell")
    np.testing.assert_allclose(one, other.T, atol=1e-15)
    table = joint.table(f"{TARGET}/lapse_1", f"{TARGET}/component")
    assert table.dims == (f"{TARGET}/lapse_1", f"{TARGET}/component")
    assert list(table[f"{TARGET}/component"].values) == ["product", "no-frame"]
    assert list(table[f"{TARGET}/lapse_1"].values) == [False, True]


def test_what_is_asked_wrongly_is_one_line(joint):
    with pytest.raises(UnknownName, match="Latent 'cell' is unknown; expected one of RedCar/cell"):
        joint.probabilities("cell")
    with pytest.raises(UnknownName, match="Value of RedCar/component 'at' is unknown; expected"):
        joint.probabilities(f"{TARGET}/cell", given={f"{TARGET}/component": "at"})
    certain = infer_description(SPOKEN, CITY, replace(MODEL, lapse=0.0))[0]
    nowhere = np.full(CITY.grid.shape, 0.0)
    nowhere[0, 0] = -np.inf
    sensed = certain.condition({TARGET: nowhere}).joint
    with pytest.raises(InputError, match=r"What is given is impossible: \{'RedCar/cell': 0\}"):
        sensed.probabilities(f"{TARGET}/component", given={f"{TARGET}/cell": 0})


def test_later_descriptions_count_on_and_have_a_component_of_their_own():
    first, _ = infer_description(SPOKEN, CITY, MODEL)
    both = first.update(said(relation("east", "House"))).joint
    assert f"{TARGET}/component[1]" in both.latents
    assert f"{TARGET}/lapse_2" in both.latents
    assert both.probabilities(f"{TARGET}/lapse_2").sum() == pytest.approx(1)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_sum_product_is_the_sum_of_the_whole_product(data):
    """Of random factor graphs of up to five latents, against numpy's einsum."""
    sizes = {name: data.draw(st.integers(1, 3)) for name in "abcde"}
    rng = np.random.default_rng(data.draw(st.integers(0, 2**31)))
    subsets = data.draw(st.lists(st.sets(st.sampled_from("abcde")), min_size=1, max_size=4))
    tables = [
        LogTable(tuple(sorted(s)), torch.from_numpy(rng.normal(size=[sizes[n] for n in sorted(s)])))
        for s in subsets
    ]
    met = sorted(set().union(*subsets))
    keep = tuple(data.draw(st.permutations(met))[: data.draw(st.integers(0, len(met)))])
    got = sum_product(tables, keep)
    equation = ",".join("".join(t.latents) for t in tables) + "->" + "".join(keep)
    expected = np.einsum(equation, *(t.values.exp().numpy() for t in tables))
    assert got.latents == keep
    np.testing.assert_allclose(got.values.exp().numpy(), expected, rtol=1e-9)


def test_contradictions_do_not_underflow():
    """Products of exponentials would be 0 here: each factor is 1e-400 where the other is 1."""
    far = torch.tensor([0.0, -950.0, -1900.0], dtype=torch.float64)
    total = sum_product([LogTable(("s",), far), LogTable(("s",), far.flip(0))], ())
    assert float(total.values) == pytest.approx(-1900.0 + np.log(3))
