"""Many threads may infer, update and condition at once; each gets the bytes it would get alone."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pyro
import pytest
import torch

import sloop_ppl as sloop
from sloop_ppl.inference import Importance, infer_batch, infer_description

TEXTS = (
    "the green toyota is behind velvet dog and near hoyt block",
    "the red bike is left of ivy",
    "the red honda is in front of rumor and the red bike is not near ivy",
    "the red bike is north of ivy",
)


@pytest.fixture
def _switching():
    """Let threads take turns as often as the interpreter can."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


def answers(first):
    """Everything that one thread does, from a map of its own with nothing derived yet."""
    city = sloop.load_map("cleveland", cell_m=10)
    told = [sloop.parse(text, city) for text in TEXTS]
    found = []
    for k in range(6):
        one, other = told[(first + k) % 4], told[(first + k + 1) % 4]
        posterior, _ = infer_description(one, city)
        target = posterior.targets[0]
        more = posterior.update(other)
        weights = np.log(np.linspace(0.1, 1, city.grid.size)).reshape(city.grid.shape)
        sensed = more.condition({target: weights})
        rng = np.random.default_rng(k)
        rough, _ = infer_description(one, city, engine=Importance(50), rng=rng)
        (batch,) = infer_batch([one], city)
        found += [
            posterior.belief(target).tobytes(),
            sensed.belief(target).tobytes(),
            repr(sensed.frames(target)),
            rough.belief(target).tobytes(),
            batch[target].tobytes(),
            float(sensed.log_evidence),
        ]
    return found


@pytest.mark.usefixtures("_switching")
def test_four_threads_give_the_same_bytes_as_one():
    alone = [answers(i) for i in range(4)]
    state, threads = torch.get_rng_state(), torch.get_num_threads()
    valid = pyro.distributions.distribution.Distribution, pyro.settings.get("validate_poutine")
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(answers, range(4)))
    assert together == alone
    assert torch.equal(torch.get_rng_state(), state)
    assert torch.get_num_threads() == threads
    assert valid[1] == pyro.settings.get("validate_poutine")


@pytest.mark.usefixtures("_switching")
def test_one_posterior_may_be_asked_by_many_threads():
    city = sloop.load_map("cleveland", cell_m=10)
    posterior = sloop.infer(TEXTS[0], city)

    def ask(_):
        return [
            posterior.belief("GreenToyota").tobytes(),
            repr(posterior.frames("GreenToyota")),
            repr(posterior.lapses("GreenToyota")),
            float(posterior.log_evidence),
        ]

    with ThreadPoolExecutor(4) as pool:
        first, *others = pool.map(ask, range(8))
    assert all(other == first for other in others)
