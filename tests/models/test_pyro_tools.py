"""Pyro's own tools work on the program, whatever the model and the sentence."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace

import numpy as np
import pyro
import pyro.distributions as dist
import pytest
import torch
from pyro import poutine
from pyro.infer import (
    MCMC,
    NUTS,
    Predictive,
    TraceEnum_ELBO,
    config_enumerate,
    infer_discrete,
)

from sloop_ppl.errors import InputError, ProgramError, UnknownName
from sloop_ppl.inference import infer_description
from sloop_ppl.models import PRESETS, build, preset
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(9, 10.0), house=(12.0, -7.0), street_y=30.0)
WITHOUT = said(relation("near", "House"), relation("on", "MainSt"))
WITH = said(relation("behind", "House"), relation("near", "MainSt"), relation("left", "House"))
TWO = said(
    relation("front", "MainSt", figure="A"),
    relation("near", "House", figure="A"),
    relation("right", "House", figure="B"),
    targets=("A", "B"),
)
SENTENCES = {"without frame words": WITHOUT, "with frame words": WITH, "two targets": TWO}
MODELS = ("bayes", "sloop", "sloop-m4")
CASES = [(m, s) for m in MODELS for s in SENTENCES]

pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture(autouse=True)
def _seeded():
    pyro.clear_param_store()
    with pyro.validation_enabled(True):
        pyro.set_rng_seed(0)
        yield


def nothing():
    """The guide of a model whose latents are all enumerated."""


def bound():
    return TraceEnum_ELBO(max_plate_nesting=0)


@pytest.mark.parametrize(("model", "sentence"), CASES)
def test_the_bound_is_the_log_evidence(model, sentence):
    """With nothing left to a guide it is exact, but for the angle bins."""
    program = build(SENTENCES[sentence], CITY, model, frame_bins=720)
    loss = bound().loss(config_enumerate(program), nothing)
    exact, _ = infer_description(SENTENCES[sentence], CITY, model)
    assert -loss == pytest.approx(float(exact.log_evidence), abs=1e-6)


@pytest.mark.parametrize("sentence", SENTENCES)
@pytest.mark.parametrize("model", [name for name in PRESETS if name != "informed"])
def test_marginals_of_every_preset_are_those_of_the_exact_engine(model, sentence):
    what = SENTENCES[sentence]
    program = build(what, CITY, model, frame_bins=360)
    marginals = bound().compute_marginals(config_enumerate(program), nothing)
    exact, _ = infer_description(what, CITY, model)
    for target in exact.targets:
        cells = marginals[f"{target}/cell"].probs.numpy()
        np.testing.assert_allclose(cells, exact.belief(target).reshape(-1), atol=2e-5)
        components = marginals[f"{target}/component"].probs.numpy()
        expected = list(exact.component(target).values())
        np.testing.assert_allclose(components[: len(expected)], expected, atol=2e-5)
        if len(expected) == 1:
            assert components[1] == 0.0, "the twin of a single component is impossible"


def test_a_long_description_has_marginals_too():
    """Seven targets of three phrases each have more sites than a tensor may have dims."""
    words = ("behind", "near", "left", "south", "front", "right", "north")
    names = tuple(f"T{i}" for i in range(7))
    long = said(
        *(relation(words[(i + k) % 7], "House", figure=n) for i, n in enumerate(names)
          for k in range(3)),
        targets=names,
    )  # fmt: skip
    marginals = bound().compute_marginals(
        config_enumerate(build(long, CITY, "bayes", frame_bins=360)), nothing
    )
    exact, _ = infer_description(long, CITY, "bayes")
    for name in names:
        got = marginals[f"{name}/cell"].probs.numpy()
        np.testing.assert_allclose(got, exact.belief(name).reshape(-1), atol=1e-6)


def test_marginals_of_frames_and_lapses_are_those_the_posterior_answers():
    program = build(WITH, CITY, "bayes", frame_bins=72)
    marginals = bound().compute_marginals(config_enumerate(program), nothing)
    exact, _ = infer_description(WITH, CITY, "bayes")
    names = {f"{TARGET}/frame_0", f"{TARGET}/frame_2", *(f"{TARGET}/lapse_{j}" for j in range(3))}
    assert names <= set(marginals)
    assert names <= set(exact.joint.latents)
    for name in names:
        expected = exact.joint.probabilities(name)
        if "lapse" in name:
            assert float(marginals[name].probs) == pytest.approx(expected[1], abs=1e-6)
        else:
            np.testing.assert_allclose(marginals[name].probs, expected, atol=1e-6)


@pytest.mark.parametrize(("model", "sentence"), CASES)
def test_sample_posterior_and_infer_discrete_draw_from_the_posterior(model, sentence):
    what = SENTENCES[sentence]
    program = build(what, CITY, model, frame_bins=12)
    exact, _ = infer_description(what, CITY, model)
    target = exact.targets[0]
    belief = exact.belief(target).reshape(-1)
    drawn = []

    def recorded():
        drawn.append(program())

    discrete = infer_discrete(config_enumerate(recorded), first_available_dim=-1)
    for draw in (
        lambda: bound().sample_posterior(config_enumerate(recorded), nothing),
        discrete,
    ):
        for _ in range(40):
            draw()
            # A cell of less than a millionth is drawn in 40 tries once in 25,000 runs.
            assert belief[int(drawn[-1][target])] > 1e-6


@pytest.mark.parametrize("parallel", [False, True])
@pytest.mark.parametrize("frames", ["bins", "density"])
def test_predictive_draws_from_the_prior(frames, parallel):
    program = build(WITH, CITY, "bayes", frames=frames, frame_bins=24)
    drawn = Predictive(program, num_samples=400, parallel=parallel)()
    cells = drawn[f"{TARGET}/cell"].double()
    # Uniform over 81 cells: mean 40, standard deviation 23.4; 5 standard errors are 5.8.
    assert float(cells.mean()) == pytest.approx(40, abs=5.8)
    share = float(drawn[f"{TARGET}/component"].double().mean())
    weight = preset("bayes").components[1].weight
    error = math.sqrt(weight * (1 - weight) / 400)
    assert share == pytest.approx(weight, abs=5 * error)
    assert drawn[f"{TARGET}/frame_0"].shape[0] == 400


@pytest.mark.parametrize(("model", "sentence"), CASES)
def test_predictive_runs_in_parallel_for_every_model(model, sentence):
    program = build(SENTENCES[sentence], CITY, model, frame_bins=12)
    drawn = Predictive(program, num_samples=7, parallel=True)()
    assert {tuple(v.shape) for k, v in drawn.items() if k.endswith("/cell")} == {(7,)}


@pytest.mark.parametrize(("model", "sentence"), CASES)
def test_condition_do_and_block(model, sentence):
    what = SENTENCES[sentence]
    program = build(what, CITY, model, frame_bins=12)
    target = program.targets[0]
    exact, _ = infer_description(what, CITY, model)
    cell = int(exact.belief(target).argmax())
    data = {f"{target}/cell": torch.tensor(cell)}
    conditioned = poutine.condition(program, data=data)
    assert int(conditioned()[target]) == cell
    loss = bound().loss(config_enumerate(conditioned), nothing)
    done = bound().loss(config_enumerate(poutine.do(program, data=data)), nothing)
    assert loss - done == pytest.approx(math.log(81)), "what is done pays no prior"
    blocked = poutine.block(program, hide=[f"{target}/component"])
    trace = poutine.trace(blocked).get_trace()
    assert f"{target}/component" not in trace.nodes
    assert f"{target}/cell" in trace.nodes


def test_a_denied_and_a_lapsed_phrase_have_the_probability_they_should():
    """Of sites fixed by hand: log(1 - g) less the log of its sum over the map; and -log S."""
    what = said(relation("near", "House", negated=True))
    model = replace(preset("bayes"), lapse=0.25)
    program = build(what, CITY, model)
    raw, _ = infer_description(what, CITY, replace(model, lapse=0.0, temper=0.0))
    for lapsed, expected in (
        (0.0, np.log(raw.belief(TARGET).reshape(-1)[13])),
        (1.0, -math.log(81)),
    ):
        fixed = poutine.condition(
            program,
            data={f"{TARGET}/cell": torch.tensor(13), f"{TARGET}/lapse_0": torch.tensor(lapsed)},
        )
        trace = poutine.trace(fixed).get_trace()
        trace.compute_log_prob()
        got = float(trace.nodes[f"{TARGET}/holds_0"]["log_prob"])
        assert got == pytest.approx(float(expected), abs=1e-9)


def test_nuts_moves_frames_and_numbers_that_were_given_priors():
    prior = dist.LogNormal(math.log(15.0), 0.3)
    program = build(WITH, CITY, "bayes", frames="density", priors={"near_street_m": prior})
    chain = MCMC(
        NUTS(program, max_tree_depth=3, max_plate_nesting=0),
        num_samples=30,
        warmup_steps=15,
        disable_progbar=True,
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # torch's, of a float32 tensor in a test
        chain.run()
    drawn = chain.get_samples()
    assert set(drawn) == {f"{TARGET}/frame_0", f"{TARGET}/frame_2", "near_street_m"}
    for values in drawn.values():
        assert len(values) == 30
        assert bool(torch.isfinite(values).all())
        assert len(values.unique()) > 5, "the chain moves"
    assert bool((drawn["near_street_m"] > 0).all())


@pytest.mark.parametrize("model", ["sloop", "sloop-m4"])
def test_nuts_over_numbers_leaves_frames_that_are_points_discrete(model):
    prior = dist.LogNormal(math.log(15.0), 0.3)
    program = build(WITH, CITY, model, frames="density", priors={"near_m": prior})
    kernel = NUTS(program, max_tree_depth=2, max_plate_nesting=0)
    chain = MCMC(kernel, num_samples=4, warmup_steps=4, disable_progbar=True)
    chain.run()
    assert list(chain.get_samples()) == ["near_m"]


def test_what_cannot_be_had_is_one_line_and_no_empty_result():
    with pytest.raises(InputError, match="Model 'sloop' has no continuous latent here: no phrase"):
        build(WITH, CITY, "sloop", frames="density")
    with pytest.raises(InputError, match="Model 'bayes' has no continuous latent here"):
        build(WITHOUT, CITY, "bayes", frames="density")
    with pytest.raises(UnknownName, match="Way to draw frames 'angles' is unknown; expected one"):
        build(WITH, CITY, frames="angles")
    with pytest.raises(UnknownName, match="Parameter of the likelihood of bayes 'wide' is unknown"):
        build(WITH, CITY, priors={"wide": dist.Normal(0.0, 1.0)})
    program = build(WITH, CITY, frames="density", priors={"near_m": dist.LogNormal(2.7, 0.1)})
    with pytest.raises(ProgramError, match="Number 'near_m' of the likelihood is drawn 3") as told:
        Predictive(program, num_samples=3, parallel=True)()
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(("model", "sentence"), CASES)
def test_the_program_can_be_drawn(model, sentence):
    graph = pyro.render_model(build(SENTENCES[sentence], CITY, model), render_distributions=True)
    for target in SENTENCES[sentence].targets:
        for site in ("component", "cell", "holds_0", "normaliser"):
            assert f"{target.id}/{site}" in graph.source
