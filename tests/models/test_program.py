"""The program is an ordinary Pyro model."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pyro
import pytest
import torch
from pyro import poutine
from pyro.infer import Predictive, TraceEnum_ELBO, config_enumerate

from sloop_ppl.errors import InputError
from sloop_ppl.inference import infer_description
from sloop_ppl.models import build
from tests.mixture import MIXTURE
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(9), street_y=18.0)
MODEL = replace(MIXTURE, lapse=0.1)
SPOKEN = said(relation("behind", "House"), relation("near", "MainSt"))


@pytest.fixture
def program():
    return build(SPOKEN, CITY, MODEL, frame_bins=24)


def test_every_latent_is_a_named_site(program):
    trace = poutine.trace(program).get_trace()
    names = {f"{TARGET}/{site}" for site in ("component", "cell", "frame_0", "lapse_0", "lapse_1")}
    assert set(trace.stochastic_nodes) >= names
    assert {f"{TARGET}/holds_0", f"{TARGET}/holds_1"} <= set(trace.observation_nodes)


def test_a_program_has_as_many_bins_as_build_gives_it():
    built = build(SPOKEN, CITY, MODEL)
    assert type(built)(built.data).bins == built.bins == 72
    assert type(built)(built.data).frames == built.frames == "bins"


@pytest.mark.parametrize("bins", [0, -1, True, 2.5, "24"])
def test_a_number_of_bins_that_is_none(bins):
    with pytest.raises(InputError) as caught:
        build(SPOKEN, CITY, MODEL, frame_bins=bins)
    assert str(caught.value) == (
        f"frame_bins is {bins!r}; expected a whole number of angles above 0"
    )


def test_one_bin_is_enough():
    assert build(SPOKEN, CITY, MODEL, frame_bins=1).bins == 1


def test_a_number_with_a_prior_is_heeded_in_every_run():
    """Tables of one run are no tables of the next, where another number was drawn."""
    priors = {"near_m": torch.distributions.LogNormal(2.0, 1.0)}
    program = build(SPOKEN, CITY, MODEL, priors=priors, frame_bins=24)

    def log_holds(program, near_m):
        data = {f"{TARGET}/cell": torch.tensor(0), "near_m": torch.tensor(near_m)}
        data |= {f"{TARGET}/{site}": torch.tensor(0) for site in ("component", "frame_0")}
        data |= {f"{TARGET}/lapse_{j}": torch.tensor(0.0) for j in (0, 1)}
        trace = poutine.trace(poutine.condition(program, data=data)).get_trace()
        trace.compute_log_prob()
        return float(trace.nodes[f"{TARGET}/holds_1"]["log_prob"])

    first, second = log_holds(program, 5.0), log_holds(program, 50.0)
    assert abs(first - second) > 0.1
    fresh = build(SPOKEN, CITY, MODEL, priors=priors, frame_bins=24)
    assert log_holds(fresh, 50.0) == second


def test_conditioning_fixes_a_site(program):
    fixed = poutine.condition(program, data={f"{TARGET}/cell": torch.tensor(7)})
    assert int(fixed()[TARGET]) == 7


def test_the_angle_of_a_front_is_a_site(program):
    """The bins start in the west and go round anticlockwise; the middle one of 24 is east."""
    for bin_, angle in ((0, -math.pi), (12, 0.0), (18, math.pi / 2)):
        fixed = poutine.condition(program, data={f"{TARGET}/frame_0": torch.tensor(bin_)})
        trace = poutine.trace(fixed).get_trace()
        assert float(trace.nodes[f"{TARGET}/angle_0"]["value"]) == pytest.approx(angle)
    assert f"{TARGET}/frame_1" not in trace.nodes


def test_doing_cuts_a_site_from_its_prior(program):
    """An intervened front adds nothing to the log probability, a conditioned one its prior."""
    data = {
        f"{TARGET}/component": torch.tensor(0),
        f"{TARGET}/cell": torch.tensor(40),
        f"{TARGET}/lapse_0": torch.tensor(0.0),
        f"{TARGET}/lapse_1": torch.tensor(0.0),
    }
    front = {f"{TARGET}/frame_0": torch.tensor(12)}
    conditioned = poutine.condition(program, data={**data, **front})
    done = poutine.do(poutine.condition(program, data=data), data=front)
    a, b = (poutine.trace(p).get_trace() for p in (conditioned, done))
    angles, log_mass = program.data.phrase(program.data.relations[0][0]).bins(24)
    assert float(angles[12]) == pytest.approx(0.0)
    b.compute_log_prob()
    a.compute_log_prob()
    holds = f"{TARGET}/holds_0"
    assert float(a.nodes[holds]["log_prob"]) == pytest.approx(float(b.nodes[holds]["log_prob"]))
    prior = float(a.nodes[f"{TARGET}/frame_0"]["log_prob"])
    assert prior == pytest.approx(float(log_mass[12]))
    assert f"{TARGET}/frame_0" not in b.observation_nodes


def test_predictive_draws_from_the_prior(program):
    pyro.set_rng_seed(0)
    drawn = Predictive(program, num_samples=400)()[f"{TARGET}/component"].flatten()
    share = torch.bincount(drawn, minlength=4).double() / 400
    # The no-frame component applies too ("near" is left): standard error below .025.
    np.testing.assert_allclose(share, program.data.log_weight[0].exp(), atol=0.1)


def test_the_enumerated_bound_is_the_log_evidence():
    """With nothing left to a guide, Pyro's TraceEnum_ELBO is exact, but for the angles' grid."""
    program = build(SPOKEN, CITY, MODEL, frame_bins=360)
    elbo = TraceEnum_ELBO(max_plate_nesting=0)
    loss = elbo.loss(config_enumerate(program), lambda: None)
    exact, _ = infer_description(SPOKEN, CITY, MODEL)
    assert -loss == pytest.approx(exact.log_evidence, abs=1e-4)


def test_the_program_can_be_drawn(program):
    graph = pyro.render_model(program)
    assert f"{TARGET}/frame_0" in graph.source


def test_tables_that_would_not_fit_are_refused():
    big = house_and_street(symmetric_grid(401), street_y=900.0)
    with pytest.raises(InputError, match="use fewer frame_bins, a smaller map, or the exact"):
        build(said(relation("behind", "House")), big, MODEL, frame_bins=720)
