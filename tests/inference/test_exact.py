"""The Pyro program, enumerated, against brute force over its own sites."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
import torch
from pyro import poutine
from pyro.infer import TraceEnum_ELBO, config_enumerate
from scipy.special import logsumexp

from sloop_ppl.inference import Enumerate, infer_description
from sloop_ppl.inference._enumeration import description_tables
from sloop_ppl.models import build, preset
from tests.mixture import MIXTURE
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(7, 10.0), house=(12.0, -7.0), street_y=30.0)
SPOKEN = (relation("behind", "House"), relation("near", "MainSt", negated=True))
ONE = said(*SPOKEN)
TWO = said(*SPOKEN, relation("left", "House", figure="RedBike"), targets=(TARGET, "RedBike"))
WARY = replace(MIXTURE, name="wary", lapse=0.1, temper=0.5)
SHARED = replace(WARY, name="shared", shared_frames=True)
MODELS = {name: preset(name) for name in ("sloop", "sloop-m2", "sloop-m4", "bayes")}
MODELS |= {model.name: model for model in (WARY, SHARED)}
CELLS = range(0, CITY.grid.size, 5)


def prior_of(description):
    """A prior for each target, shape (N, S), and its log."""
    prior = np.random.default_rng(0).dirichlet(np.ones(CITY.grid.size), len(description.targets))
    return prior, torch.from_numpy(np.log(prior))


def log_joint(program, sites):
    """Condition the program on the values of some sites and read its log probability."""
    data = {name: torch.as_tensor(np.asarray(value)) for name, value in sites.items()}
    fixed = poutine.condition(program, data=data)
    return float(poutine.trace(fixed).get_trace().log_prob_sum())


@pytest.mark.parametrize("name", MODELS)
def test_enumeration_equals_brute_force(name):
    """Condition the program on every (component, cell) and read its log probability."""
    _, log_prior = prior_of(ONE)
    program = build(ONE, CITY, MODELS[name], frames="summed", log_prior=log_prior)
    got = description_tables(program)[0].numpy()
    assert got.shape == (len(MODELS[name].components), CITY.grid.size)
    for k, s in itertools.product(range(len(got)), CELLS):
        total = log_joint(program, {f"{TARGET}/component": k, f"{TARGET}/cell": s})
        total -= float(log_prior[0, s])
        if np.isneginf(got[k, s]):
            assert np.isneginf(total)
        else:
            assert got[k, s] == pytest.approx(total, abs=1e-9)


@pytest.mark.parametrize("name", ["sloop", "bayes", "wary"])
def test_enumeration_sums_over_frames_and_lapses(name):
    """The same with the sites of one phrase drawn: sum over all their values by hand."""
    _, log_prior = prior_of(ONE)
    model = MODELS[name]
    program = build(ONE, CITY, model, log_prior=log_prior, frame_bins=6)
    sites = {f"{TARGET}/frame_0": range(1 if name == "sloop" else 6)}
    sites |= {f"{TARGET}/lapse_{j}": (0.0, 1.0) for j in range(2) if model.lapse}
    got = description_tables(program)[0].numpy()
    for k, s in itertools.product(range(len(got)), (0, 24, 45)):
        at = {f"{TARGET}/component": k, f"{TARGET}/cell": s}
        each = [
            log_joint(program, at | dict(zip(sites, values, strict=True)))
            for values in itertools.product(*sites.values())
        ]
        assert got[k, s] == pytest.approx(logsumexp(each) - float(log_prior[0, s]), abs=1e-9)


@pytest.mark.parametrize("name", MODELS)
def test_two_targets_are_brute_force_too(name):
    """The log probability of both is the sum of one table each, given what they share."""
    _, log_prior = prior_of(TWO)
    program = build(TWO, CITY, MODELS[name], frames="summed", log_prior=log_prior)
    tables = [table.numpy() for table in description_tables(program)]
    rng = np.random.default_rng(1)
    for _ in range(40):
        sites, total = {}, 0.0
        shared = [int(rng.integers(len(latent.support))) for latent in program.data.shared]
        for latent, value in zip(program.data.shared, shared, strict=True):
            sites[latent.name] = value
            total += float(latent.log_prior[value])
        for i, target in enumerate(program.targets):
            k, s = int(rng.integers(tables[i].shape[-2])), int(rng.integers(CITY.grid.size))
            sites |= {f"{target}/component": k, f"{target}/cell": s}
            total += tables[i][(*shared, k, s)] + float(log_prior[i, s])
        assert bool(shared) == (name == "shared")
        assert log_joint(program, sites) == pytest.approx(total, abs=1e-9)


@pytest.mark.parametrize("frames", ["summed", "bins"])
@pytest.mark.parametrize("what", [ONE, TWO], ids=["one", "two"])
@pytest.mark.parametrize("name", MODELS)
def test_the_joint_agrees_with_pyros_own_marginals(name, what, frames):
    """Component and cell of each target, and what they share; `sloop` has one component only."""
    prior, log_prior = prior_of(what)
    program = build(what, CITY, MODELS[name], frames=frames, log_prior=log_prior)
    elbo = TraceEnum_ELBO(max_plate_nesting=0)
    marginals = elbo.compute_marginals(config_enumerate(program), lambda: None)
    engine = "exact" if frames == "summed" else Enumerate(frame_bins=program.bins)
    priors = {t: p.reshape(CITY.grid.shape) for t, p in zip(program.targets, prior, strict=True)}
    posterior, _ = infer_description(what, CITY, MODELS[name], engine, prior=priors)
    names = [f"{t}/{site}" for t in program.targets for site in ("component", "cell")]
    for site in (*names, *(latent.name for latent in program.data.shared)):
        expected = marginals[site].probs.reshape(-1).numpy()
        got = posterior.joint.probabilities(site)
        np.testing.assert_allclose(got, expected[: len(got)], atol=1e-12)
        np.testing.assert_array_equal(expected[len(got) :], 0.0)  # one value's impossible twin


@pytest.mark.parametrize("what", [ONE, TWO], ids=["one", "two"])
@pytest.mark.parametrize("name", MODELS)
def test_the_latents_of_a_phrase_agree_with_pyros_own_marginals(name, what):
    """Frames and lapses, which the posterior sums out and brings back when they are asked for."""
    program = build(what, CITY, MODELS[name])
    elbo = TraceEnum_ELBO(max_plate_nesting=0)
    marginals = elbo.compute_marginals(config_enumerate(program), lambda: None)
    joint = infer_description(what, CITY, MODELS[name], Enumerate(frame_bins=72))[0].joint
    asked = [site for site in joint.latents if "/lapse_" in site or "/frame_" in site]
    assert {site for site in marginals if "/lapse_" in site or "/frame_" in site} == set(asked)
    for site in asked:
        support = marginals[site].enumerate_support().reshape(-1)
        expected = marginals[site].log_prob(support).exp()
        # A lapse is told by the closed form over frames, which bins meet but at the kinks of g.
        kinked = "/lapse_" in site and name != "bayes"
        got = joint.probabilities(site)
        np.testing.assert_allclose(
            got, expected[: len(got)], rtol=0, atol=1e-4 if kinked else 1e-12
        )


def test_several_targets_are_inferred_as_each_alone():
    both = said(
        relation("behind", "House", figure="RedCar"),
        relation("near", "MainSt", figure="RedBike"),
        relation("on", "MainSt", figure="RedBike"),
        targets=("RedCar", "RedBike"),
    )
    joint, _ = infer_description(both, CITY, "sloop-m4")
    for target in ("RedCar", "RedBike"):
        alone, _ = infer_description(said(*both.about(target), targets=(target,)), CITY, "sloop-m4")
        np.testing.assert_allclose(joint.belief(target), alone.belief(target), atol=1e-12)


def test_log_evidence_is_the_sum_over_component_and_cell():
    prior, log_prior = prior_of(ONE)
    program = build(ONE, CITY, "bayes", frames="summed", log_prior=log_prior)
    expected = logsumexp((description_tables(program)[0] + log_prior[0]).numpy())
    posterior, info = infer_description(ONE, CITY, "bayes", prior=prior[0].reshape(CITY.grid.shape))
    assert posterior.log_evidence == pytest.approx(float(expected))
    assert info.log_evidence == posterior.log_evidence


def test_a_target_of_which_nothing_is_said_keeps_its_prior():
    what = said(relation("near", "House"), targets=(TARGET, "RedBike"))
    posterior, info = infer_description(what, CITY, "sloop-m4")
    assert info.not_located == ("RedBike",)
    np.testing.assert_allclose(posterior.belief("RedBike"), 1 / CITY.grid.size)
    assert posterior.component("RedBike") == {}
    assert posterior.frames("RedBike") == ()
