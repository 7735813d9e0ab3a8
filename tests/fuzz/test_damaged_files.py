"""Damaged files of every kind: read as something finite, or refused in one line.

Seeded; ``--fuzz-rounds N`` makes N times as many damaged files.
"""

from __future__ import annotations

import json
import math
import random

import numpy as np
import pytest
import xarray

from sloop_ppl.errors import SloopError
from sloop_ppl.eval import _fits as fits
from sloop_ppl.eval import bundled_examples
from sloop_ppl.eval._annotation_files import read_annotations
from sloop_ppl.eval.descriptions import read_descriptions
from sloop_ppl.inference import Posterior, infer_description
from sloop_ppl.inference.prior import log_priors
from sloop_ppl.language import load_targets, parse
from sloop_ppl.maps import load_map
from sloop_ppl.models import preset
from sloop_ppl.models.cell_priors import learn_cells
from sloop_ppl.models.frames._network import load_weights
from sloop_ppl.models.frames.learned import shipped_weights
from sloop_ppl.models.tuning import load_parameters, with_parameters
from sloop_ppl.planning import SearchConfig, read_episode, run_search, write_episode
from tests.scenes import TARGET, relation, said
from tests.support.damage import damaged_bytes, damaged_json
from tests.support.small_searches import city_of
from tests.support.small_sweeps import LINES

CITY = load_map("cleveland")

TARGETS = json.dumps(
    [
        {"id": "Tom", "names": ["tom", "the cat"], "kind": "cat", "colour": "red"},
        {"id": "Van", "names": []},
    ]
)
PARAMETERS = {
    "likelihood": {"near_m": 12.0},
    "model": {"lapse": 0.1, "temper": 0.9},
    "frames": {"kappa": 2.0},
}
TOML = "[likelihood]\nnear_m = 12.0\n[model]\nlapse = 0.1\ntemper = 0.9\n[frames]\nkappa = 2.0\n"


@pytest.fixture
def rounds(request):
    return request.config.getoption("--fuzz-rounds")


def attempt(read, label):
    """Return what was read, or None when it was refused in one line."""
    try:
        return read()
    except SloopError as error:
        message = str(error)
        assert "\n" not in message, (label, message)
        assert len(message) < 5000, (label, len(message))
        return None


def check_tuned(path):
    tuned = with_parameters(preset("bayes"), load_parameters(path))
    assert math.isfinite(tuned.lapse)
    assert math.isfinite(tuned.temper)


def check_prior(path):
    for table in log_priors(path, (TARGET,), CITY).values():
        assert np.exp(table).sum() == pytest.approx(1)


def check_episode(path):
    episode = read_episode(path)
    assert math.isfinite(episode.discounted_return)
    assert episode.views.shape[0] == episode.steps + 1


def read_lines(path):
    return read_descriptions(path)


def fuzz(tmp_path, text, name, read, count, damage=damaged_json):
    """Read damaged copies of a file; return how many were refused."""
    path, refused = tmp_path / name, 0
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    read(path)  # as it was
    for seed in range(count):
        path.write_bytes(damage(text, random.Random(seed)))
        refused += attempt(lambda: (read(path), True), f"{name}, seed {seed}") is None
    assert refused > count / 20  # what is always taken was not damaged
    return refused


def test_targets(tmp_path, rounds):
    fuzz(tmp_path, TARGETS, "targets.json", load_targets, 400 * rounds)


def test_parameters(tmp_path, rounds):
    fuzz(tmp_path, json.dumps(PARAMETERS), "p.json", check_tuned, 300 * rounds)
    fuzz(tmp_path, TOML.encode(), "p.toml", check_tuned, 300 * rounds, damaged_bytes)


def test_learnt_priors(tmp_path, rounds):
    learn_cells([(CITY, (0.0, 0.0)), (CITY, (20.0, 10.0))]).save(tmp_path / "p.json")
    fuzz(tmp_path, (tmp_path / "p.json").read_text(), "p.json", check_prior, 300 * rounds)


def test_episodes(tmp_path, rounds):
    told = run_search(
        {"A": np.ones((5, 6)), "B": np.ones((5, 6))},
        city_of(5, 6),
        {"A": (11.0, 12.0), "B": (3.0, 20.0)},
        planner="greedy",
        config=SearchConfig(sims=10, max_steps=4),
        rng=np.random.default_rng(2),
        keep_beliefs=True,
    )
    write_episode(told, tmp_path / "e.json")
    fuzz(tmp_path, (tmp_path / "e.json").read_text(), "e.json", check_episode, 500 * rounds)


@pytest.mark.parametrize("line", LINES, ids=[line["id"] for line in LINES])
def test_description_lines(tmp_path, rounds, line):
    line = {**line, "hearer": {"east_m": 1.0, "north_m": 2.0}, "area_m": [-90, -90, 90, 90]}
    fuzz(tmp_path, json.dumps(line), "l.jsonl", read_lines, 150 * rounds)


def test_annotations(tmp_path, rounds):
    entry = {"figure": "A", "relation": "near", "ground": "B", "group": 0, "distance_m": [5, None]}
    text = json.dumps({"id": "one", "relations": [entry, {**entry, "negated": True}]})
    fuzz(tmp_path, text, "a.jsonl", read_annotations, 300 * rounds)


def test_kept_fits(tmp_path, rounds, monkeypatch):
    examples, models = bundled_examples()[:8], {"bayes": preset("bayes")}
    monkeypatch.setattr(fits, "git_state", lambda: None)
    monkeypatch.setattr(fits, "refits", lambda *_, **__: {})
    key = fits._key(examples, models, load_map)
    kept = {"bayes": dict.fromkeys(key["maps"], PARAMETERS)}
    text = json.dumps({"format": fits._FORMAT, "key": key, "fits": kept})

    def read(path):
        return fits.cross_validated(examples, models, load_map, kept=path)

    fuzz(tmp_path, text, "f.json", read, 100 * rounds)


def test_weights(tmp_path, rounds):
    data = shipped_weights("ego").read_bytes()

    def damage(whole, rng):  # the header is small beside the numbers
        size = int.from_bytes(whole[:8], "little") + 8
        return damaged_bytes(whole[:size], rng) + whole[size:]

    fuzz(tmp_path, data, "w.safetensors", load_weights, 100 * rounds, damage)
    fuzz(tmp_path, data, "w.safetensors", load_weights, 20 * rounds, damaged_bytes)


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    path = tmp_path_factory.mktemp("saved") / "p.nc"
    told = said(relation("behind", "VelvetDog"), relation("near", "Ivy"))
    infer_description(told, CITY, "bayes")[0].save(path)
    return path


def check_posterior(path):
    posterior = Posterior.load(path)
    for target in posterior.targets:
        belief = posterior.belief(target)
        assert np.isfinite(belief).all()
        assert belief.sum() == pytest.approx(1)


def test_posteriors_whose_bytes_were_damaged(tmp_path, rounds, saved):
    data = saved.read_bytes()
    fuzz(tmp_path, data, "p.nc", check_posterior, 30 * rounds, damaged_bytes)
    fuzz(tmp_path, data, "p.nc", check_prior, 30 * rounds, damaged_bytes)


ODD_NUMBERS = (np.nan, np.inf, -np.inf, -1.0, 1e308, 7.0)


def damaged_dataset(data, rng):
    """Return a posterior's tables and texts with one of them changed."""
    name = rng.choice([*data.attrs, *data.variables])
    if name in data.attrs:
        value = data.attrs[name]
        if isinstance(value, str) and value[:1] in "[{":
            value = damaged_json(value, rng).decode("utf-8", "replace").replace("\0", "")
        else:
            value = rng.choice([0, -1.5, float("nan"), "x", "exact", value, ""])
        return data.assign_attrs({name: value})
    what = rng.random()
    array = data[name]
    if what < 0.15 and name in data.data_vars:
        return data.drop_vars(name)
    if what < 0.35 and array.dims:
        dim = rng.choice(array.dims)
        return data.isel({dim: rng.choice([slice(1, None), slice(None, None, 2), [0, 0]])})
    if array.dtype.kind not in "fi":
        return data.assign({name: (array.dims, np.full(array.shape, "odd"))})
    values = array.values.copy()
    at = tuple(rng.randrange(n) for n in values.shape)
    if array.dtype.kind == "i":
        values[at] = rng.choice([-1, 1, 99, 2**40])
    elif what < 0.7:
        values[at] = rng.choice(ODD_NUMBERS)
    else:
        values[...] = rng.choice(ODD_NUMBERS)
    return data.assign({name: (array.dims, values)})


@pytest.mark.parametrize("digest", [True, False])
def test_posteriors_whose_tables_were_changed(tmp_path, rounds, saved, digest):
    with xarray.open_dataset(saved, engine="h5netcdf") as opened:
        whole = opened.load()
    if not digest:
        sections = json.loads(whole.attrs["sections"])
        del sections["digest"], whole.attrs["tables_digest"]
        whole.attrs["sections"] = json.dumps(sections)
    path = tmp_path / "changed.nc"
    for seed in range(40 * rounds):
        changed = damaged_dataset(whole, random.Random(seed))
        try:
            changed.to_netcdf(path, engine="h5netcdf")
        except Exception:  # what cannot be written is no file
            continue
        attempt(lambda: check_posterior(path), f"seed {seed}")
        attempt(lambda: check_prior(path), f"prior, seed {seed}")


def test_sentences(rounds):
    texts = [annotated.text for annotated in bundled_examples()[:10]]
    for seed in range(60 * rounds):
        rng = random.Random(seed)
        text = damaged_bytes(rng.choice(texts).encode(), rng).decode("utf-8", "replace")
        attempt(lambda text=text: parse(text, CITY), f"seed {seed}")
