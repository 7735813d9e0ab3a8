from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pyro
import pytest
import torch
from pyro import poutine

from sloop_ppl.inference import infer_description
from sloop_ppl.models import build
from tests.mixture import MIXTURE
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(5), house=(5.0, -3.0), street_y=9.0)
WARY = replace(MIXTURE, lapse=0.2)
CLASH = said(relation("near", "House"), relation("at", "House"), relation("at", "MainSt"))


def test_lapses_are_those_of_the_program():
    """Enumerate component, cell and lapses of the Pyro program one by one."""
    program = build(CLASH, CITY, WARY)
    sums = torch.zeros(3)
    total = 0.0
    with pyro.validation_enabled(False):
        for z, s, *lapsed in itertools.product(range(4), range(25), *(range(2),) * 3):
            values = {f"{TARGET}/component": torch.tensor(z), f"{TARGET}/cell": torch.tensor(s)}
            values |= {f"{TARGET}/lapse_{j}": torch.tensor(float(b)) for j, b in enumerate(lapsed)}
            trace = poutine.trace(poutine.condition(program, values)).get_trace()
            p = math.exp(float(trace.log_prob_sum()))
            if p > 0:
                total += p
                sums += p * torch.tensor(lapsed)
    post, _ = infer_description(CLASH, CITY, WARY)
    assert [lapse.p for lapse in post.lapses(TARGET)] == pytest.approx(
        (sums / total).tolist(), abs=1e-6
    )
    assert [lapse.prior for lapse in post.lapses(TARGET)] == pytest.approx([0.2] * 3)


def test_the_odd_one_out_is_suspected():
    city = house_and_street(symmetric_grid(41), house=(60.0, -60.0), street_y=90.0)
    near, at, odd = infer_description(CLASH, city, WARY)[0].lapses(TARGET)
    assert odd.p > 0.5
    assert max(near.p, at.p) < 0.3
    assert odd.relation.ground == "MainSt"
    assert [near.index, at.index, odd.index] == [0, 1, 2]


def test_a_model_that_trusts_everything_suspects_nothing():
    post, _ = infer_description(CLASH, CITY, "sloop-m4")
    assert [(lapse.p, lapse.prior) for lapse in post.lapses(TARGET)] == [(0, 0)] * 3


def test_shared_fronts_are_weighed():
    model = replace(WARY, shared_frames=True)
    both = said(relation("front", "House"), relation("behind", "House"))
    alone = said(relation("front", "House"))
    (one, other) = infer_description(both, CITY, model)[0].lapses(TARGET)
    (single,) = infer_description(alone, CITY, model)[0].lapses(TARGET)
    assert min(one.p, other.p) > single.p
    assert one.p + other.p > 0.4
