"""Every engine against the exact one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from sloop_ppl.errors import InputError
from sloop_ppl.inference import Importance, Nuts, Svi, infer_description
from sloop_ppl.models import Component, ground_description, preset, program_data
from tests.mixture import MIXTURE
from tests.scenes import house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(21), house=(12.0, -7.0), street_y=30.0)
BAYES = preset("bayes")
MODELS = {
    "sloop-m4": preset("sloop-m4"),
    "bayes": BAYES,
    "lapse": replace(BAYES, lapse=0.1),
    "tempered, shared error": replace(BAYES, lapse=0.1, temper=0.5, error_m=8.0),
    "shared frames": replace(BAYES, lapse=0.1, shared_frames=True),
    "truth": replace(BAYES, normalisation="truth", lapse=0.05),
    "speaker": replace(
        BAYES,
        normalisation="speaker",
        lapse=0.05,
        components=(Component("product", 0.7), Component("no-frame", 0.3, keep_frames=False)),
    ),
}
SPOKEN = said(
    relation("behind", "House", figure="A"),
    relation("left", "House", figure="A"),
    relation("near", "MainSt", negated=True, figure="A"),
    relation("front", "House", figure="B"),
    relation("south", "MainSt", figure="B"),
    targets=("A", "B"),
)


def total_variation(a, b):
    return max(0.5 * np.abs(a.belief(t) - b.belief(t)).sum() for t in a.targets)


@pytest.mark.parametrize("name", MODELS)
def test_full_enumeration_agrees_with_exact(name):
    exact, info = infer_description(SPOKEN, CITY, MODELS[name])
    full, full_info = infer_description(SPOKEN, CITY, MODELS[name], "enumerate")
    assert total_variation(exact, full) < 1e-5
    assert full_info.log_evidence == pytest.approx(info.log_evidence, abs=1e-4)
    for target in exact.targets:
        assert full.component(target) == pytest.approx(exact.component(target), abs=1e-5)


@pytest.mark.parametrize("name", ["bayes", "lapse", "shared frames"])
def test_importance_sampling_agrees_within_its_error(name):
    exact, _ = infer_description(SPOKEN, CITY, MODELS[name])
    rough, _ = infer_description(
        SPOKEN, CITY, MODELS[name], Importance(draws=1000), rng=np.random.default_rng(0)
    )
    assert total_variation(exact, rough) < 0.06
    fine, _ = infer_description(
        SPOKEN, CITY, MODELS[name], "importance", rng=np.random.default_rng(0)
    )
    assert total_variation(exact, fine) < 0.02


@pytest.mark.parametrize("engine", ["nuts", "svi"])
def test_engines_with_gradients_leave_threads_and_generators_alone(engine):
    torch.manual_seed(5)
    before, threads = torch.get_rng_state(), torch.get_num_threads()
    few = {"nuts": Nuts(warmup=2, draws=3), "svi": Svi(steps=2, draws=3)}
    what = said(relation("behind", "House"), relation("near", "MainSt"))
    data = program_data(ground_description(what, CITY, BAYES), CITY, BAYES)
    runs = [few[engine].weigh(data, np.random.default_rng(3))[0] for _ in range(2)]
    assert torch.equal(torch.get_rng_state(), before)
    assert torch.get_num_threads() == threads
    np.testing.assert_array_equal(runs[0], runs[1])


@pytest.mark.parametrize("engine", ["importance", "nuts", "svi"])
def test_engines_that_draw_want_an_rng(engine):
    with pytest.raises(InputError, match=rf"Engine '{engine}' draws; give rng="):
        infer_description(SPOKEN, CITY, "bayes", engine)


@pytest.mark.parametrize("engine", ["nuts", "svi"])
def test_points_have_no_gradient(engine):
    with pytest.raises(InputError, match=rf"Engine '{engine}' needs frames with a density"):
        infer_description(SPOKEN, CITY, "sloop", engine, rng=np.random.default_rng(0))


@pytest.mark.parametrize("engine", ["nuts", "svi"])
@pytest.mark.parametrize("model", ["keyword", "uniform", "informed"])
def test_frames_that_no_component_reads_want_no_density(engine, model):
    """What was said of a point of a front does not matter to them."""
    truth = {"A": (0.0, 0.0), "B": (10.0, 5.0)}
    got, _ = infer_description(
        SPOKEN, CITY, model, engine, truth=truth, rng=np.random.default_rng(0)
    )
    exact, _ = infer_description(SPOKEN, CITY, model, truth=truth)
    assert total_variation(exact, got) < 1e-9


def test_a_fixed_front_is_taken_whatever_its_prior():
    what = said(relation("front", "House"))
    east, _ = infer_description(what, CITY, "bayes", do={"frame": {"House": 0.0}})
    belief = east.belief("RedCar")
    house = CITY.grid.cell_at(12.0, -7.0)[1]
    assert belief[:, house + 1 :].sum() > 3 * belief[:, :house].sum()
    one, _ = infer_description(what, CITY, MIXTURE, do={"component": "near"})
    assert one.component("RedCar") == {"near": 1.0}
    with pytest.raises(InputError, match="Intervention 'cell' is unknown; expected one of frame"):
        infer_description(what, CITY, "bayes", do={"cell": 3})
    with pytest.raises(InputError, match="Front is 'up'; expected a finite number of radians"):
        infer_description(what, CITY, "bayes", do={"frame": {"House": "up"}})


def test_the_map_a_description_was_read_on_must_match():
    from dataclasses import replace as changed

    with pytest.raises(InputError, match="read on map 'elsewhere'; expected 'block'"):
        infer_description(changed(SPOKEN, map="elsewhere"), CITY)


@pytest.mark.parametrize("engine", [Nuts(warmup=2, draws=3), Svi(steps=2, draws=3)])
def test_engines_with_gradients_run_where_gradients_are_off(engine):
    def belief():
        rng = np.random.default_rng(3)
        return infer_description(SPOKEN, CITY, "bayes", engine, rng=rng)[0].belief("A")

    with torch.no_grad():
        without = belief()
        assert not torch.is_grad_enabled()
    np.testing.assert_array_equal(without, belief())
