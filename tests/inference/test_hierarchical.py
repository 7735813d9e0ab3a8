"""Draws of parameters: the right posterior, reloadable, the same for the same seed."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import torch
import xarray

import sloop_ppl as sloop
from sloop_ppl.errors import InputError, OutputError, UnknownName
from sloop_ppl.inference import ParameterDraws, sample_parameters
from sloop_ppl.inference._enumeration import seeded_torch
from sloop_ppl.inference._free_parameters import FreeParameters
from sloop_ppl.inference.hierarchical import _chain, _Target
from sloop_ppl.inference.learning import Example, curvature, maximise
from sloop_ppl.models import preset
from sloop_ppl.models._vocabulary import speakable_grounds
from sloop_ppl.models.simulation import SPEAKER, simulate
from sloop_ppl.models.tuning import load_parameters, with_parameters


def described(city, speaker, count, rng, model=SPEAKER):
    names = [f"T{i}" for i in range(count)]
    grounds = speakable_grounds(city)[:2]
    drawn = simulate(city, names, rng, model=model, phrases=2, grounds=grounds)
    cells = {name: drawn.latents[name].cell for name in names}
    return Example(drawn.description, city, cells, speaker)


@pytest.fixture(scope="module")
def city():
    return sloop.load_map("cleveland", cell_m=10.0)


@pytest.fixture(scope="module")
def examples(city):
    rng = np.random.default_rng(0)
    return [described(city, speaker, 4, rng) for speaker in ("Ann", "Bo")]


@pytest.fixture(scope="module")
def drawn(examples):
    lines = []
    found = sample_parameters(
        examples,
        SPEAKER,
        rng=np.random.default_rng(1),
        learn=["kappa_compass", "weights"],
        vary=["kappa_compass"],
        warmup=6,
        draws=20,
        progress=lines.append,
    )
    return found, lines


class Gaussian:
    """A score of a known posterior: each speaker is measured once, the first more surely."""

    size, told = 2, "score"

    def scores(self, free, z, deviations):
        own = z[0] + deviations.get(0, torch.zeros(2, dtype=torch.float64))
        return -0.5 * torch.stack([4 * (own[0] - 1) ** 2, (own[1] + 1) ** 2 + (z[1] - z[0]) ** 2])


def chain(target, speakers, warmup=80, draws=400):
    with seeded_torch(np.random.default_rng(0)):
        return _chain(target, speakers, warmup, draws, lambda line: None)


def test_draws_follow_a_posterior_that_is_known_by_hand():
    free, known = FreeParameters(SPEAKER, ["near_m", "tail"]), Gaussian()
    top, _ = maximise(free, known, iterations=50)
    target = _Target(free, known, (), top, curvature(free, known, top))
    found, diverged = chain(target, 0)
    z = target.numbers(found).numpy()
    precision = np.array([[4 + 1 + 1 + 1, -1], [-1, 1 + 1]])  # measurements, their tie, priors
    covariance = np.linalg.inv(precision)
    assert diverged == 0
    # Some 400 draws, nearly independent: five standard errors.
    np.testing.assert_allclose(z.mean(0), covariance @ [3, 0], atol=5 * (0.6 / 400) ** 0.5)
    np.testing.assert_allclose(np.cov(z.T), covariance, atol=5 * 0.6 * (2 / 400) ** 0.5)


@pytest.mark.slow
def test_the_spread_between_speakers_is_that_of_quadrature():
    free, known = FreeParameters(SPEAKER, ["near_m", "tail"]), Gaussian()
    top, _ = maximise(free, known, iterations=50)
    target = _Target(free, known, (0,), top, curvature(free, known, top))
    found, _ = chain(target, 2, warmup=120, draws=500)
    spread = found["log_spread"][:, 0].exp().numpy()
    z0 = target.numbers(found)[:, 0].numpy()
    # Speakers' deviations are summed out: measurement s has variance 1 / precision + spread^2.
    s, z = np.meshgrid(np.linspace(0.005, 3, 400), np.linspace(-3, 3, 301), indexing="ij")
    log_p = -0.5 * (s / 0.5) ** 2 - 0.5 * z**2 - 0.25 * z**2  # the tied number: variance 2
    for at, variance in ((1.0, 0.25), (-1.0, 1.0)):
        log_p += -0.5 * (z - at) ** 2 / (variance + s**2) - 0.5 * np.log(variance + s**2)
    p = np.exp(log_p - log_p.max())
    p /= p.sum()
    assert spread.mean() == pytest.approx(float((p * s).sum()), abs=0.1)
    assert z0.mean() == pytest.approx(float((p * z).sum()), abs=0.15)


def test_draws_name_what_they_are_of(drawn):
    found, lines = drawn
    shapes = {name: dict(array.sizes) for name, array in found.dataset.data_vars.items()}
    assert shapes == {
        "kappa_compass": {"chain": 2, "draw": 20},
        "weights": {"chain": 2, "draw": 20, "component": 2},
        "kappa_compass_by_speaker": {"chain": 2, "draw": 20, "speaker": 2},
        "kappa_compass_spread": {"chain": 2, "draw": 20},
    }
    np.testing.assert_allclose(found.dataset["weights"].sum("component"), 1)
    assert float(found.dataset["kappa_compass_spread"].min()) > 0
    assert found.speakers == ("Ann", "Bo")
    assert "weights[uninformative]" in found.r_hat
    assert found.ess["kappa_compass_by_speaker[Bo]"] > 0
    assert found.provenance["targets"] == 8
    assert found.provenance["seed"] == "1"
    assert set(found.provenance["versions"]) >= {"torch", "pyro-ppl", "sloop-ppl"}
    assert any(line.startswith("chain 2 of 2: sample step") for line in lines)
    table = str(found).splitlines()
    assert len(table) == 1 + len(found.summary) == 1 + 6
    assert table[0].split() == ["median", "2.5", "%", "97.5", "%", "r-hat", "ess"]


def test_medians_are_parameters_of_the_population_and_of_a_speaker(drawn):
    found, _ = drawn
    own = found.parameters_of("Bo")["likelihood"]["kappa_compass"]
    of_bo = found.dataset["kappa_compass_by_speaker"].sel(speaker="Bo")
    assert own == pytest.approx(float(of_bo.median()))
    assert found.parameters["likelihood"]["kappa_compass"] != own
    assert found.apply(SPEAKER, "Bo").likelihood.kappa_compass == own
    assert sum(found.parameters["weights"].values()) == pytest.approx(1)
    with pytest.raises(UnknownName, match="Speaker 'Cy' is unknown; expected one of Ann, Bo"):
        found.parameters_of("Cy")


def test_what_is_saved_reloads_whole_and_as_parameters(drawn, tmp_path):
    found, _ = drawn
    path = tmp_path / "drawn.json"
    found.save(path)
    again = ParameterDraws.load(path)
    xarray.testing.assert_identical(again.dataset, found.dataset)
    assert (again.model, again.provenance) == (found.model, dict(found.provenance))
    assert with_parameters(SPEAKER, load_parameters(path)) == found.apply(SPEAKER)
    told = json.loads(path.read_text())
    assert told["speakers"]["Ann"] == found.parameters_of("Ann")
    assert told["summary"]["kappa_compass"]["r_hat"] == found.r_hat["kappa_compass"]
    with pytest.raises(OutputError, match=r"ends in '\.toml'"):
        found.save(tmp_path / "drawn.toml")


def test_a_file_without_draws(tmp_path):
    (tmp_path / "a.json").write_text("{}")
    with pytest.raises(InputError, match="holds no draws of parameters"):
        ParameterDraws.load(tmp_path / "a.json")
    with pytest.raises(InputError, match="cannot be read: No such file"):
        ParameterDraws.load(tmp_path / "b.json")


def test_arviz_gets_the_draws(drawn):
    pytest.importorskip("arviz")
    told = drawn[0].to_arviz()
    assert told.posterior["kappa_compass_by_speaker"].dims == ("chain", "draw", "speaker")
    assert told.posterior.attrs["model"] == "speaker"


def test_the_same_seed_draws_the_same_and_leaves_torch_alone(examples):
    torch.manual_seed(3)
    before = torch.get_rng_state()
    one, other = (
        sample_parameters(
            examples[:1], SPEAKER, rng=np.random.default_rng(4), learn=["near_m"],
            warmup=2, draws=20, chains=1,
        )
        for _ in range(2)
    )  # fmt: skip
    xarray.testing.assert_identical(one.dataset, other.dataset)
    assert torch.equal(torch.get_rng_state(), before)
    assert one.speakers == ()
    assert set(one.r_hat) == {"near_m"}


def test_a_model_without_words_is_drawn_by_its_beliefs(examples):
    model = replace(preset("bayes"), lapse=0.1)
    found = sample_parameters(
        [replace(one, cells=dict(list(one.cells.items())[:2])) for one in examples],
        model, rng=np.random.default_rng(0), learn=["near_m"], vary=["near_m"],
        warmup=2, draws=20, chains=1,
    )  # fmt: skip
    assert found.provenance["objective"].startswith("log score of known cells")
    assert bool(np.isfinite(found.dataset["near_m_by_speaker"]).all())


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"draws": 19}, "draws is 19; expected at least 20"),
        ({"warmup": 0}, "warmup is 0; expected at least 1"),
        ({"chains": 0}, "chains is 0; expected at least 1"),
        ({"learn": ["width"]}, "'width' of model 'speaker' cannot be learnt; expected one of"),
        ({"vary": ["lapse"]}, "'lapse' cannot vary from speaker to speaker; expected one of"),
        ({"learn": ["tail"], "vary": ["near_m"]}, "'near_m' cannot vary .* frames: tail"),
    ],
)
def test_what_cannot_be_drawn(examples, given, message):
    with pytest.raises(InputError, match=message):
        sample_parameters(examples, SPEAKER, rng=np.random.default_rng(0), **given)


def test_speakers_are_needed_to_vary_between(examples):
    rng = np.random.default_rng(0)
    with pytest.raises(InputError, match="The examples have 1 speakers; expected at least two"):
        sample_parameters(examples[:1], SPEAKER, rng=rng, learn=["tail"], vary=["tail"])
    nameless = [*examples, replace(examples[0], speaker=None)]
    with pytest.raises(InputError, match="Example 2 has no speaker; expected one"):
        sample_parameters(nameless, SPEAKER, rng=rng, learn=["tail"], vary=["tail"])


def test_no_example_at_all():
    with pytest.raises(InputError, match="No example says anything of a target whose cell"):
        sample_parameters([], SPEAKER, rng=np.random.default_rng(0))


@pytest.mark.slow
def test_speakers_who_differ_are_told_apart(city):
    rng = np.random.default_rng(7)
    vague, sharp = (
        with_parameters(SPEAKER, {"likelihood": {"kappa_compass": kappa}}) for kappa in (1.2, 7.0)
    )
    spoken = [described(city, "vague", 80, rng, vague), described(city, "sharp", 80, rng, sharp)]
    found = sample_parameters(
        spoken, SPEAKER, rng=np.random.default_rng(1), learn=["kappa_compass", "lapse"],
        vary=["kappa_compass"], warmup=40, draws=60,
    )  # fmt: skip
    rows = {row.name: row for row in found.summary}
    assert (
        rows["kappa_compass_by_speaker[vague]"].high < rows["kappa_compass_by_speaker[sharp]"].low
    )
    assert rows["kappa_compass_by_speaker[vague]"].low < 1.2
    assert rows["kappa_compass_by_speaker[sharp]"].high > 7.0
    assert rows["kappa_compass_spread"].low > 0.2
    assert max(row.r_hat for row in found.summary) < 1.1
    assert found.provenance["divergences"] == 0
    assert math.isclose(rows["lapse"].median, 0.1, abs_tol=0.1)
