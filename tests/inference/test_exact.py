"""The Pyro program, enumerated, against brute force over its own sites."""

from __future__ import annotations

import numpy as np
import pyro
import pytest
import torch
from pyro import poutine
from pyro.infer import TraceEnum_ELBO, config_enumerate
from scipy.special import logsumexp

from sloop_ppl.inference import enumerated_log_factors, infer_description
from sloop_ppl.models import gather_evidence, ground_relations, observation_model, preset
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(7, 10.0), house=(12.0, -7.0), street_y=30.0)
SPOKEN = (relation("behind", "House"), relation("near", "MainSt", negated=True))


def evidence_and_prior(model="sloop-m4"):
    evidence = gather_evidence([ground_relations(SPOKEN, CITY)], CITY, preset(model))
    rng = np.random.default_rng(0)
    log_prior = torch.from_numpy(np.log(rng.dirichlet(np.ones(CITY.grid.size))))[None]
    return evidence, log_prior


@pytest.mark.parametrize("model", ["sloop-m2", "sloop-m4", "bayes"])
def test_enumeration_equals_brute_force(model):
    """Condition the program on every (component, cell) and read its log probability."""
    evidence, log_prior = evidence_and_prior(model)
    got = enumerated_log_factors(evidence, log_prior)[0, 0].numpy()
    for k in range(len(evidence.components)):
        for s in range(0, CITY.grid.size, 5):
            fixed = poutine.condition(
                observation_model,
                data={
                    "component": torch.tensor([[k]]),
                    "cell": torch.tensor([[s]]),
                },
            )
            trace = poutine.trace(fixed).get_trace(evidence, log_prior)
            total = float(trace.log_prob_sum()) - float(log_prior[0, s])
            if np.isneginf(got[k, s]):
                assert np.isneginf(total)
            else:
                assert got[k, s] == pytest.approx(total, abs=1e-9)


def test_the_joint_agrees_with_pyros_own_marginals():
    """For two targets, since Pyro's marginals fail on plates of size one (pyro #3102)."""
    evidence = gather_evidence([ground_relations(SPOKEN, CITY)] * 2, CITY, preset("sloop-m4"))
    log_prior = evidence_and_prior()[1].expand(2, -1)
    pyro.clear_param_store()
    elbo = TraceEnum_ELBO(max_plate_nesting=2)
    marginals = elbo.compute_marginals(
        config_enumerate(observation_model), lambda *_: None, evidence, log_prior
    )
    log_joint = enumerated_log_factors(evidence, log_prior)[1, 0] + log_prior[1]
    posterior = (log_joint - torch.logsumexp(log_joint.reshape(-1), 0)).exp().numpy()
    cells = marginals["cell"].probs[1].reshape(-1).numpy()
    components = marginals["component"].probs[1].reshape(-1).numpy()
    np.testing.assert_allclose(posterior.sum(0), cells, atol=1e-7)
    np.testing.assert_allclose(posterior.sum(1), components, atol=1e-7)


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
    evidence, log_prior = evidence_and_prior("bayes")
    expected = logsumexp((enumerated_log_factors(evidence, log_prior)[0, 0] + log_prior[0]).numpy())
    posterior, info = infer_description(
        said(*SPOKEN), CITY, "bayes", prior=np.exp(log_prior[0].numpy()).reshape(CITY.grid.shape)
    )
    assert posterior.log_evidence == pytest.approx(float(expected))
    assert info.log_evidence == posterior.log_evidence


def test_a_target_of_which_nothing_is_said_keeps_its_prior():
    what = said(relation("near", "House"), targets=(TARGET, "RedBike"))
    posterior, info = infer_description(what, CITY, "sloop-m4")
    assert info.not_located == ("RedBike",)
    np.testing.assert_allclose(posterior.belief("RedBike"), 1 / CITY.grid.size)
    assert posterior.component("RedBike") == {}
    assert posterior.frames("RedBike") == ()
