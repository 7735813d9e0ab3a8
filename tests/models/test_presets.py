from __future__ import annotations

import pytest

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.models import PRESETS, Component, ObservationModel, preset


def test_the_papers_six_methods_ours_and_a_comparator():
    assert list(PRESETS) == [
        "uniform", "keyword", "informed", "sloop", "sloop-m2", "sloop-m4", "bayes",
        "referent-gaussian",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "weights"),
    [
        ("sloop", {"product": 1.0}),
        ("sloop-m2", {"product": 0.8, "near": 0.2}),
        ("sloop-m4", {"product": 0.6, "no-frame": 0.25, "at": 0.1, "near": 0.05}),
    ],
)
def test_weights_are_those_of_the_published_code(name, weights):
    assert {c.name: c.weight for c in preset(name).components} == weights


def test_a_preset_passes_through():
    assert preset(preset("bayes")) is PRESETS["bayes"]


def test_the_paper_variant_does_not_cut():
    assert any(c.cut for c in preset("sloop-m4").components)
    assert not any(c.cut for c in preset("sloop-m4", "paper").components)


def test_unknown_variant_lists_both():
    with pytest.raises(UnknownName, match="expected one of published, paper"):
        preset("sloop", "draft")


def test_only_sloop_has_a_paper_variant():
    with pytest.raises(InputError, match="Model 'keyword' has no variant 'paper'"):
        preset("keyword", "paper")


def test_a_model_needs_a_component_and_a_sane_lapse():
    parts = {"likelihood": preset("sloop").likelihood, "frame_prior": preset("sloop").frame_prior}
    with pytest.raises(InputError, match="has no component"):
        ObservationModel("mine", (), **parts)
    with pytest.raises(InputError, match="lapse 1; expected 0 <= lapse < 1"):
        ObservationModel("mine", (Component("product"),), lapse=1, **parts)
    with pytest.raises(InputError, match="weight 0; expected a positive number"):
        Component("product", 0)
