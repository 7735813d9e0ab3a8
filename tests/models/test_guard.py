"""A model given in Python with a likelihood of one's own is checked at every call."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np
import pytest
import torch

from sloop_ppl.errors import InputError
from sloop_ppl.inference import Example, fit, infer_batch, infer_description
from sloop_ppl.models import GaussianLikelihood, build, preset
from sloop_ppl.models._guard import GuardedLikelihood
from sloop_ppl.models.simulation import SPEAKER, simulate
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(11), house=(0.0, -10.0), street_y=20.0)
SAID = said(relation("near", "MainSt"), relation("behind", "House"))


@dataclass(frozen=True)
class Mine:
    """The paper's likelihood, spoilt."""

    spoil: str = ""

    def log_g(self, term, direction_rad):
        table = GaussianLikelihood().log_g(term, direction_rad)
        if self.spoil == "fails" and direction_rad is not None:
            raise RuntimeError("no such front")
        return {
            "": table,
            "fails": table,
            "positive": table + 1.0,
            "nan": table * float("nan"),
            "numpy": table.numpy(),
            "half": table.float(),
            "turned": table.mT if table.dim() == 2 else table,
            "first row": table[0] if direction_rad is not None else table,
            "no axis for cells": table.sum(-1),
        }[self.spoil]


@dataclass(frozen=True)
class Summed(Mine):
    """One with an expectation of its own, which is no log probability."""

    def log_marginal(self, term, frame):
        return GaussianLikelihood().log_marginal(term, frame) + 1.0


def of(likelihood):
    return replace(preset("bayes"), name="mine", likelihood=likelihood)


def raised(run):
    with pytest.raises(InputError) as error:
        run()
    return str(error.value)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        ("positive", "of MainSt (site 'holds', phrase 0) is 1 at its highest; expected at most 0"),
        ("nan", "is nan at 121 of 121 places; expected finite logs: give g a small floor"),
        ("numpy", "is a ndarray; expected a torch.Tensor"),
        ("half", "has dtype torch.float32; expected torch.float64"),
        ("first row", "(site 'holds', phrase 1) has shape (121,); expected (1, 121), that is (B"),
        ("turned", "has shape (121, 1); expected (1, 121), that is (B directions, S cells)"),
        ("no axis for cells", "has shape (); expected (121,), that is (S cells,)"),
    ],
)
def test_what_it_returns_is_checked(spoil, message):
    assert message in raised(lambda: infer_description(SAID, CITY, of(Mine(spoil))))


def test_what_it_raises_is_said_with_its_line():
    assert re.fullmatch(
        r"log_g of 'Mine' fails for relation 'behind' of House \(site 'holds', phrase 1\) "
        r"at line \d+ of test_guard.py: RuntimeError: no such front",
        raised(lambda: infer_description(SAID, CITY, of(Mine("fails")))),
    )


def test_its_own_expectation_is_checked():
    message = raised(lambda: infer_description(SAID, CITY, of(Summed())))
    assert message.startswith("log_marginal of 'Summed' for relation 'behind' of House")
    assert "at its highest; expected at most 0" in message


@pytest.mark.parametrize(
    "run",
    [
        lambda model: build(SAID, CITY, model)(),
        lambda model: infer_batch([SAID], CITY, model),
        lambda model: infer_description(SAID, CITY, model, "enumerate"),
        lambda model: infer_description(
            SAID, CITY, model, "importance", rng=np.random.default_rng()
        ),
    ],
)
def test_every_road_into_a_model_is_guarded(run):
    assert "expected at most 0" in raised(lambda: run(of(Mine("positive"))))


def test_a_sound_one_gives_what_it_gave():
    own = infer_description(SAID, CITY, of(Mine()))[0]
    paper = infer_description(SAID, CITY, of(GaussianLikelihood()))[0]
    assert isinstance(own.model.likelihood, GuardedLikelihood)
    assert preset(own.model) is own.model
    assert isinstance(paper.model.likelihood, GaussianLikelihood)
    assert 0.5 * np.abs(own.belief(TARGET) - paper.belief(TARGET)).sum() < 1e-5
    assert torch.equal(
        torch.from_numpy(own.update(SAID).belief(TARGET)),
        torch.from_numpy(own.update(SAID).belief(TARGET)),
    )


def test_a_checked_one_simulates_and_is_fitted_at_some_cells_only():
    speaks = preset(replace(SPEAKER, name="mine", likelihood=Mine()))
    drawn = simulate(CITY, [TARGET], np.random.default_rng(0), model=speaks, phrases=2)
    example = Example(drawn.description, CITY, {TARGET: drawn.latents[TARGET].cell})
    assert isinstance(speaks.likelihood, GuardedLikelihood)
    assert fit([example], speaks, learn=["lapse"], iterations=5, intervals=False).parameters


def test_what_is_no_likelihood_is_refused():
    message = raised(lambda: infer_description(SAID, CITY, of("gaussian-clipped")))
    assert message == (
        "Likelihood is a str; expected an object with a method log_g(term, direction_rad), such as "
        "one of sloop_ppl.models.LIKELIHOODS"
    )
