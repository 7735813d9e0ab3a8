"""Scores of beliefs against known places."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.eval import bundled_examples
from sloop_ppl.eval._belief_scores import score_belief
from sloop_ppl.eval._quality_files import models_named, quality_lines, score_quality
from sloop_ppl.eval.descriptions import Place
from sloop_ppl.eval.quality import score_beliefs
from sloop_ppl.maps import Grid
from sloop_ppl.models import preset

SHARED = Path(__file__).parents[2].parent / "shared" / "data" / "descriptions"


@pytest.fixture
def grid():
    return Grid(0, 0, 10, 10, cell_m=5.0)  # 3 x 3 cells


def test_a_belief_is_scored_by_hand(grid):
    belief = np.array([[0.5, 0.2, 0.1], [0.1, 0.1, 0.0], [0.0, 0.0, 0.0]])
    x, y = grid.x_m[1], grid.y_m[0]
    score = score_belief(belief, grid, Place(x, y, (0, 1)))
    assert score.log_score == pytest.approx(math.log(0.2))
    assert (score.rank, score.in_hpd90) == (1.0, 1.0)
    expected = 0.5 * 5 + 0.1 * 5 + 0.1 * math.hypot(5, 5) + 0.1 * 5
    assert score.expected_distance_m == pytest.approx(expected)
    assert score.mass_15m == pytest.approx(1.0)


def test_ties_count_by_half(grid):
    belief = np.array([[0.5, 0.2, 0.1], [0.1, 0.1, 0.0], [0.0, 0.0, 0.0]])
    score = score_belief(belief, grid, Place(grid.x_m[2], grid.y_m[0], (0, 2)))
    # Two cells are higher and two tied; the 90 % region takes two of the three.
    assert (score.rank, score.in_hpd90) == (3.0, pytest.approx(2 / 3))
    nowhere = score_belief(belief, grid, Place(grid.x_m[0], grid.y_m[2], (2, 0)))
    assert nowhere.log_score == pytest.approx(math.log(1e-300))
    assert (nowhere.rank, nowhere.in_hpd90) == (5 + 1.5, 0.0)


def test_mass_within_15_m_ends_at_15_m():
    grid = Grid.square(100)
    belief = np.zeros(grid.shape)
    row, col = grid.cell_at(0, 0)
    belief[row, col], belief[row, col + 3] = 0.3, 0.2  # 0 m and 15 m: in
    belief[row + 2, col - 2] = 0.1  # 14.1 m: in
    belief[row - 4, col] = 0.25  # 20 m: out
    belief[row + 3, col + 1] = 0.15  # 15.8 m: out
    x, y = grid.centre_of(row, col)
    assert score_belief(belief, grid, Place(x, y, (row, col))).mass_15m == pytest.approx(0.6)


@pytest.fixture(scope="module")
def descriptions():
    return [annotated for annotated in bundled_examples() if annotated.map == "austin"][:3]


def score(descriptions, *names, **options):
    models = {name: preset(name) for name in names}
    return score_beliefs(descriptions, models, rng=np.random.default_rng(0), **options)


def test_the_baselines_are_what_they_must_be(descriptions):
    quality = score(descriptions, "uniform", "informed")
    uniform, informed = quality.models["uniform"], quality.models["informed"]
    n = sum(len(annotated.targets) for annotated in descriptions)
    assert (uniform.n, informed.n) == (n, n)
    assert uniform.mean_log_score == pytest.approx(-math.log(1681))
    assert uniform.ci95 == pytest.approx((-math.log(1681),) * 2)
    assert (uniform.median_rank, informed.median_rank) == (840, 0)
    assert uniform.hpd90_coverage == pytest.approx(0.9, abs=1e-3)
    told = quality.paired["uniform-informed"]
    assert told.mean == pytest.approx(uniform.mean_log_score - informed.mean_log_score)


def test_what_was_not_read_is_uniform_and_not_dropped(descriptions):
    silent = [replace(annotated, relations=annotated.relations[:1]) for annotated in descriptions]
    quality = score(silent, "bayes", "informed").models["bayes"]
    unread = [
        scored
        for scored in quality.scores
        if not any(s.about(scored.target) for s in silent if s.id == scored.description)
    ]
    assert len(unread) == quality.n - len(descriptions)
    assert all(s.score.log_score == pytest.approx(-math.log(1681)) for s in unread)
    nonsense = [replace(annotated, text="hello there") for annotated in descriptions]
    parsed = score(nonsense, "bayes", "informed", relations="parsed")
    assert parsed.models["bayes"].mean_log_score == pytest.approx(-math.log(1681))
    assert parsed.models["informed"].mean_log_score > -5.5


def test_the_same_call_gives_the_same_interval(descriptions):
    assert score(descriptions, "bayes", "sloop") == score(descriptions, "bayes", "sloop")


def test_a_paired_interval_does_not_depend_on_the_other_models(descriptions):
    alone = score(descriptions, "bayes", "uniform").paired["bayes-uniform"]
    among = score(descriptions, "sloop", "bayes", "uniform").paired["bayes-uniform"]
    assert alone == among


def test_a_line_without_places_is_passed_over(descriptions):
    placeless = replace(descriptions[0], id="other", targets={})
    assert score([*descriptions, placeless], "uniform") == score(descriptions, "uniform")
    with pytest.raises(InputError, match="No description says where its targets are"):
        score([placeless], "uniform")


def test_parameters_go_to_the_model_they_are_of(tmp_path):
    file = tmp_path / "p.json"
    numbers = {"weights": {"product": 0.9}}
    file.write_text(json.dumps({"model": "sloop-m4", "parameters": numbers}))
    tuned = models_named("sloop-m4,bayes", file)
    assert tuned["sloop-m4"].components[0].weight == 0.9
    assert tuned["bayes"] == preset("bayes")
    file.write_text(json.dumps(numbers))
    tuned = models_named("sloop-m4,bayes", file)
    assert tuned["sloop-m4"] == preset("sloop-m4")
    assert tuned["bayes"].components[0].weight == 0.9
    with pytest.raises(InputError, match="are of none of the models sloop; the paper's methods"):
        models_named("sloop", file)


def test_bad_names():
    with pytest.raises(UnknownName, match="Model 'bays' is unknown"):
        models_named("bays")
    with pytest.raises(InputError, match="hold an empty or repeated name; give each once"):
        models_named("bayes,,sloop")


@pytest.mark.skipif(not SHARED.is_dir(), reason="the real descriptions are not here")
def test_the_paper_s_methods_stand_where_they_were_measured():
    # The figures are those of the published rules on the same descriptions; its raster of the
    # maps is a little different, so the models that use it agree less exactly.
    quality = score_quality(sorted(SHARED.glob("*.jsonl")))
    expected = {"uniform": -7.43, "keyword": -7.97, "informed": -4.96}
    for name, figure in expected.items():
        assert quality.models[name].mean_log_score == pytest.approx(figure, abs=0.01)
    for name, figure in {"sloop": -8.58, "sloop-m2": -5.36, "sloop-m4": -5.35}.items():
        assert quality.models[name].mean_log_score == pytest.approx(figure, abs=0.2)
    assert len(quality_lines(quality)) > 6
