"""Models in a file of the user's own, and parameters in another."""

from __future__ import annotations

import json
import math
import re

import pytest

from sloop_ppl.bridge._requests import model_of
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference import infer_description
from sloop_ppl.models import preset
from sloop_ppl.models.check import check_likelihood
from sloop_ppl.models.likelihoods import parameters_of
from sloop_ppl.models.tuning import load_parameters, with_parameters
from sloop_ppl.models.user import load_model
from tests.scenes import TARGET, point_city, relation, said, symmetric_grid

CITY = point_city(symmetric_grid(11), Pole=(0.0, 0.0))
MINE = """
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import torch

from sloop_ppl.models import preset
from sloop_ppl.models.likelihoods import Parameter

_HIDDEN = 1
NUMBER = 3


@dataclass(frozen=True)
class Exponential:
    parameters: ClassVar = (Parameter("reach_m", "m", 0, float("inf"), 10.0, 0.7, "reach"),)
    reach_m: float = 10.0

    def log_g(self, term, direction_rad):
        falling = -term.off_m / self.reach_m
        return falling if direction_rad is None else falling.expand(len(direction_rad), -1)


narrow = Exponential(4.0)
uniform_like = replace(preset("sloop"), likelihood=Exponential(1e9))


def flat(term, direction_rad):
    shape = term.distance_m.shape
    return torch.zeros(shape if direction_rad is None else (len(direction_rad), *shape)).double()


def made():
    return Exponential(20.0)


def needs_three(a, b, c):
    return a


def positive(term, direction_rad):
    return flat(term, direction_rad) + 1


def broken(term, direction_rad):
    return term.distance_m / nothing


def quits():
    raise SystemExit("enough")
"""


@pytest.fixture
def mine(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(MINE)
    return path


def belief(model, word="near"):
    return infer_description(said(relation(word, "Pole")), CITY, model)[0].belief(TARGET)


@pytest.mark.parametrize("name", ["Exponential", "narrow", "made", "flat", "uniform_like"])
def test_what_a_file_may_hold(mine, name):
    model = load_model(f"{mine}:{name}")
    assert model.name == f"mine.py:{name}"
    assert belief(model).sum() == pytest.approx(1)
    check_likelihood(model.likelihood)


def test_a_narrow_one_is_narrower(mine):
    peak = {name: belief(load_model(f"{mine}:{name}")).max() for name in ("narrow", "made")}
    assert peak["narrow"] > peak["made"]
    assert belief(load_model(f"{mine}:flat")).max() == pytest.approx(1 / 121)


def refused(spec, kind=InputError):
    with pytest.raises(kind) as error:
        load_model(spec)
    assert "\n" not in str(error.value)
    return str(error.value)


def test_a_file_without_a_name_lists_what_is_there(mine):
    assert refused(str(mine)) == (
        f"Model '{mine}' names no model of the file; there are: mine.py:Exponential, "
        "mine.py:narrow, mine.py:uniform_like, mine.py:flat, mine.py:made, mine.py:positive, "
        "mine.py:broken, mine.py:quits"
    )


def test_a_name_that_is_not_there_lists_what_is(mine):
    message = refused(f"{mine}:narow", UnknownName)
    assert message.startswith("Model of mine.py 'narow' is unknown; expected one of Exponential, n")
    assert message.endswith("did you mean 'narrow'?")


def test_a_file_that_is_not_there(tmp_path):
    path = tmp_path / "none.py"
    assert refused(f"{path}:X") == f"Model file '{path}' does not exist; give FILE.py:NAME"


@pytest.mark.parametrize(("name", "kind"), [("NUMBER", "int"), ("needs_three", "function")])
def test_something_else_is_no_model(mine, name, kind):
    assert refused(f"{mine}:{name}") == (
        f"Model 'mine.py:{name}' is a {kind}; expected an ObservationModel, a likelihood with a "
        "method log_g(term, direction_rad), or a function log_g(term, direction_rad)"
    )


def test_an_error_in_the_file_is_one_line(mine):
    mine.write_text("import math\n\nWIDTH = math.sqrt(\n    -1)\n")
    assert re.fullmatch(
        r"Model 'mine.py' fails at line 3: ValueError: .+", refused(f"{mine}:WIDTH")
    )
    mine.write_text("x = 1\ndef f(:\n")
    assert refused(f"{mine}:f") == "Model 'mine.py' fails at line 2: SyntaxError: invalid syntax"


def test_a_function_that_quits_is_one_line(mine):
    assert re.fullmatch(
        r"Model 'mine.py:quits' fails at line \d+: SystemExit: enough", refused(f"{mine}:quits")
    )


def test_what_fails_later_says_where(mine):
    with pytest.raises(InputError) as error:
        belief(load_model(f"{mine}:broken"))
    assert re.fullmatch(
        r"log_g of 'mine.py:broken' fails for relation 'near' of Pole \(site 'holds', phrase 0\) "
        r"at line \d+ of mine.py: NameError: name 'nothing' is not defined",
        str(error.value),
    )


def test_positive_logs_are_refused(mine):
    with pytest.raises(InputError) as error:
        belief(load_model(f"{mine}:positive"))
    assert str(error.value) == (
        "log_g of 'mine.py:positive' for relation 'near' of Pole (site 'holds', phrase 0) is 1 at "
        "its highest; expected at most 0: g is a probability"
    )


def test_parameters_from_a_file(mine, tmp_path):
    path = tmp_path / "tuned.toml"
    path.write_text("[likelihood]\nreach_m = 5\n[model]\nlapse = 0.1\n[weights]\nno-frame = 0.5\n")
    model = model_of(f"{mine}:Exponential", params=path)
    assert model.likelihood.inner.reach_m == 5.0
    assert model.lapse == 0.1
    assert {c.name: c.weight for c in model.components}["no-frame"] == 0.5
    assert [p.name for p in parameters_of(model.likelihood)] == ["reach_m"]


def test_json_with_provenance_is_read_as_well(tmp_path):
    path = tmp_path / "fit.json"
    path.write_text(json.dumps({"seed": 3, "parameters": {"likelihood": {"near_m": 12.5}}}))
    model = with_parameters(preset("sloop"), load_parameters(path))
    assert model.likelihood.near_m == 12.5
    assert preset("sloop").likelihood.near_m == 15.0


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"likelihoods": {}}, "Section of parameters 'likelihoods' is unknown; expected one of "),
        ({"likelihood": {"near": 1}}, "Parameter of GaussianLikelihood 'near' is unknown"),
        ({"likelihood": {"near_m": 0}}, "Parameter 'near_m' is 0 m; expected more than 0 and less"),
        ({"likelihood": {"near_m": True}}, "Parameter 'near_m' is True; expected a number of unit"),
        ({"model": {"lapse": 1.0}}, "has lapse 1.0; expected 0 <= lapse < 1"),
        ({"model": {"lapse": "x"}}, "Parameter 'lapse' is 'x'; expected a number"),
        ({"model": {"name": "x"}}, "Parameter of the model 'name' is unknown; expected one of "),
        ({"model": {"joint_grounds": 1}}, "Switch 'joint_grounds' is 1; expected true or false"),
        ({"frames": {"sigma": 1}}, "Parameter of PredictedSpread 'sigma' is unknown; expected one"),
        ({"frames": {"lapse": 1.5}}, "Parameter 'lapse' of frames is 1.5; expected it from 0 to 1"),
        ({"frames": {"kappa": 0}}, "Parameter 'kappa' of frames is 0; expected it more than 0"),
        ({"frames": {"kappa": math.nan}}, "Parameter 'kappa' is NaN; expected a number"),
        ({"model": {"temper": math.nan}}, "Parameter 'temper' is NaN; expected a number"),
        ({"weights": {"far": 1}}, "Component of model bayes 'far' is unknown; expected one of pro"),
        (
            {"weights": {"no-frame": -1}},
            "Component 'no-frame' has weight -1.0; expected a positive number",
        ),
    ],
)
def test_wrong_parameters_are_named(values, message):
    from dataclasses import replace

    from sloop_ppl.models import GaussianLikelihood

    model = replace(preset("bayes"), likelihood=GaussianLikelihood())
    with pytest.raises(InputError, match=re.escape(message)):
        with_parameters(model, values)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("near_m = 3\n", "has numbers outside a section; put them under one of [likelihood], [mod"),
        ("[likelihood\n", "is no TOML: "),
    ],
)
def test_a_file_that_is_no_parameters(tmp_path, text, message):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=re.escape(message)):
        load_parameters(path)
    with pytest.raises(InputError, match="cannot be read: No such file"):
        load_parameters(tmp_path / "none.toml")


def test_a_users_model_has_no_variant(mine):
    with pytest.raises(InputError, match="has no variant 'paper'; leave --variant out"):
        model_of(f"{mine}:flat", "paper")


def test_a_fixed_front_may_lie_anywhere():
    from dataclasses import replace

    from sloop_ppl.models import FRAME_PRIORS

    model = replace(preset("bayes"), frame_prior=FRAME_PRIORS["fixed"])
    turned = with_parameters(model, {"frames": {"front_rad": -1.5, "kappa": math.inf}})
    assert turned.frame_prior.front_rad == -1.5
    with pytest.raises(InputError, match="'front_rad' of frames is inf; expected it finite"):
        with_parameters(model, {"frames": {"front_rad": math.inf}})
