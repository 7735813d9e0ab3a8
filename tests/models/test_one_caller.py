"""The likelihood is asked in one place: every call of it comes from models/program.py."""

from __future__ import annotations

import inspect
from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

import sloop_ppl.models.program as program_module
from sloop_ppl.inference import (
    Enumerate,
    Exact,
    Example,
    Importance,
    Nuts,
    Svi,
    fit,
    infer_batch,
    infer_description,
)
from sloop_ppl.models import Component, PredictedSpread, preset
from sloop_ppl.models.likelihoods import StudentVonMisesLikelihood
from sloop_ppl.models.simulation import SPEAKER, simulate
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(7, 10.0), house=(12.0, -7.0), street_y=30.0)
SPOKEN = said(relation("behind", "House"), relation("near", "MainSt", negated=True))
PROGRAM = Path(program_module.__file__).resolve()
HOUSE = PROGRAM.parents[1]

CALLERS: Counter[str] = Counter()


def noted(method):
    """Note the file of ours that a call comes from, those of the likelihoods left out."""

    def call(self, *args):
        frame = inspect.currentframe().f_back
        while frame is not None:
            path = Path(frame.f_code.co_filename).resolve()
            ours = HOUSE in path.parents and ".venv" not in path.parts
            if ours and "likelihoods" not in path.parts and path != Path(__file__).resolve():
                CALLERS[str(path)] += 1
                break
            frame = frame.f_back
        return method(self, *args)

    return call


@dataclass(frozen=True)
class Spy(StudentVonMisesLikelihood):
    """A likelihood that notes who asks it."""

    log_g = noted(StudentVonMisesLikelihood.log_g)
    log_marginal = noted(StudentVonMisesLikelihood.log_marginal)


@dataclass(frozen=True)
class OpenSpy:
    """One without a closed form, whose frames are summed by quadrature."""

    inner: StudentVonMisesLikelihood = field(default_factory=StudentVonMisesLikelihood)

    @noted
    def log_g(self, term, direction_rad):
        return self.inner.log_g(term, direction_rad)


@pytest.fixture(autouse=True)
def _trusted(monkeypatch):
    """Leave the check of a user's tables out, which stands between a program and a likelihood."""
    from sloop_ppl.models import presets

    monkeypatch.setattr(presets, "trusted", lambda likelihood: True)
    CALLERS.clear()
    yield
    assert CALLERS, "the likelihood was asked"
    assert set(CALLERS) == {str(PROGRAM)}


MODEL = replace(
    preset("bayes"),
    likelihood=Spy(),
    lapse=0.1,
    frame_prior=PredictedSpread(lapse=0.0),
    components=(Component("product", 0.8), Component("at", 0.2, combine="sum", read_as="at")),
)
ENGINES = [
    Exact(),
    Enumerate(24),
    Importance(20),
    Nuts(warmup=1, draws=2),
    Svi(steps=2, draws=2),
]


@pytest.mark.parametrize("engine", ENGINES, ids=lambda engine: engine.name)
def test_every_engine_and_every_question(engine):
    rng = np.random.default_rng(0)
    posterior, _ = infer_description(SPOKEN, CITY, MODEL, engine, rng=rng)
    posterior = posterior.update(said(relation("left", "House")), rng)
    posterior.frames(TARGET)
    posterior.frame(TARGET, relation=0)
    posterior.joint_frame(TARGET, relation=0)
    posterior.lapses(TARGET)
    posterior.influence(TARGET, rng)
    posterior.phrase_tables(TARGET)
    posterior.draws(TARGET, 3, rng=rng)
    for latent in posterior.joint.latents:
        posterior.joint.probabilities(latent)


def test_a_likelihood_without_a_closed_form():
    infer_description(SPOKEN, CITY, replace(MODEL, likelihood=OpenSpy()))
    infer_batch([SPOKEN], CITY, replace(MODEL, likelihood=OpenSpy()))
    example = Example(SPOKEN, CITY, {TARGET: (3, 3)})
    fit([example], replace(MODEL, likelihood=OpenSpy()), learn=["lapse"], iterations=1)


def test_shared_frames():
    shared = replace(MODEL, shared_frames=True)
    what = said(relation("behind", "House"), relation("left", "House"))
    posterior, _ = infer_description(what, CITY, shared)
    posterior.frames(TARGET)
    infer_description(what, CITY, shared, Enumerate(24))


def test_speakers_fits_and_simulation():
    speaker = replace(SPEAKER, likelihood=Spy())
    rng = np.random.default_rng(0)
    drawn = simulate(CITY, [TARGET], rng, model=speaker, phrases=2)
    infer_description(drawn.description, CITY, speaker)
    cells = {TARGET: drawn.latents[TARGET].cell}
    for model in (speaker, MODEL):
        example = Example(drawn.description, CITY, cells)
        fit([example], model, learn=["near_m"], iterations=1, intervals=False)
