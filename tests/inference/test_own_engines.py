"""An engine from outside: what it returns is checked, and what it makes is saved if registered."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.inference import Exact, compare, infer_description
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(11), house=(6.0, -8.0), street_y=20.0)
NEAR = said(relation("near", "House"))


@dataclass(frozen=True)
class Mine:
    change: object
    name: str = "mine"

    def weigh(self, data, rng=None):
        return self.change(Exact().weigh(data, rng))


def test_an_engine_of_ones_own_is_as_good_as_another():
    mine, _ = infer_description(NEAR, CITY, "bayes", Mine(lambda tables: tables))
    exact, _ = infer_description(NEAR, CITY)
    np.testing.assert_array_equal(mine.belief(TARGET), exact.belief(TARGET))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda _: None, "Engine 'mine' returned as tables NoneType; expected a tuple of 1"),
        (lambda tables: (*tables, *tables), "returned as tables 2 of them; expected a tuple of 1"),
        (lambda tables: (tables[0][:, :-1],), r"returned a table of shape \(\d, 120\) for 'T'"),
        (lambda tables: (tables[0].tolist(),), "returned a table of list for 'T'"),
        (lambda tables: (tables[0] * np.nan,), "returned NaN for 'T'; expected log factors"),
    ],
)
def test_tables_that_do_not_fit_are_refused_in_one_line(change, message):
    with pytest.raises(InputError, match=message.replace("'T'", f"'{TARGET}'")):
        infer_description(NEAR, CITY, "bayes", Mine(change))


def test_what_could_not_be_read_again_is_not_saved(tmp_path):
    mine, _ = infer_description(NEAR, CITY, "bayes", Mine(lambda tables: tables))
    with pytest.raises(InputError, match="Engine 'mine' is not registered"):
        mine.save(tmp_path / "mine.nc")
    assert not list(tmp_path.iterdir())


def test_an_update_takes_a_description():
    posterior, _ = infer_description(NEAR, CITY)
    with pytest.raises(InputError, match="What is said is a str; expected a description"):
        posterior.update("it is near the house")


def test_one_engine_is_not_several():
    rng = np.random.default_rng(0)
    for engines in ("exact", Exact()):
        with pytest.raises(InputError, match="expected several of them"):
            compare(NEAR, CITY, engines=engines, rng=rng)


def test_a_joint_is_asked_by_names():
    joint = infer_description(NEAR, CITY)[0].joint
    with pytest.raises(InputError, match="Latents are asked for by name"):
        joint.probabilities([f"{TARGET}/cell"])
    with pytest.raises(InputError, match="`given` is 'literal'; expected a mapping"):
        joint.probabilities(f"{TARGET}/cell", given="literal")


def test_the_log_evidence_does_not_depend_on_what_was_asked_before():
    fresh, asked = (infer_description(NEAR, CITY)[0] for _ in range(2))
    asked.joint.probabilities(f"{TARGET}/component", f"{TARGET}/cell")
    assert float(fresh.log_evidence) == float(asked.log_evidence)
