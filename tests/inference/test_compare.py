from __future__ import annotations

import io

import numpy as np
import pytest
from rich.console import Console

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference import ENGINES, Exact, compare, infer_description
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(11), house=(12.0, -7.0), street_y=20.0)
SAID = said(relation("behind", "House"))


class Refusing:
    name = "refusing"

    def weigh(self, data, rng):
        raise InputError("Engine 'refusing' does nothing; use another")


class Tilted:
    """The exact factors, with the western half of the map twice as likely."""

    name = "tilted"

    def weigh(self, data, rng):
        columns = np.arange(data.n_cells) % data.city.grid.n_cols
        west = np.where(columns < 5, np.log(2), 0.0)
        return tuple(table + west for table in Exact().weigh(data, rng))


@pytest.fixture
def engines(monkeypatch):
    entries = {engine.name: engine for engine in (Exact(), Tilted(), Refusing())}
    monkeypatch.setattr(ENGINES, "_entries", entries)


@pytest.mark.usefixtures("engines")
def test_engines_are_compared_with_the_exact_one():
    table = compare(SAID, CITY, rng=np.random.default_rng(0))
    assert [run.engine for run in table.runs] == ["exact", "tilted", "refusing"]
    assert table["exact"].worst == 0
    right = infer_description(SAID, CITY)[0].belief(TARGET)
    wrong = right * np.where(np.arange(11) < 5, 2, 1)
    apart = 0.5 * np.abs(right - wrong / wrong.sum()).sum()
    assert table["tilted"].total_variation == {TARGET: pytest.approx(apart)}
    assert table["refusing"].refused == "Engine 'refusing' does nothing; use another"
    assert np.isnan(table["refusing"].worst)
    told = str(table).splitlines()
    assert told[0] == "| engine | total variation from exact | log evidence | seconds |"
    assert told[2].startswith("| exact | 0.0e+00 | ")
    assert told[4].endswith("does nothing; use another |")
    shown = io.StringIO()
    Console(file=shown, width=120).print(table.to_rich())
    assert "model bayes" in shown.getvalue()
    assert "tilted" in shown.getvalue()


def test_only_the_engines_that_are_named_run():
    table = compare(SAID, CITY, "sloop-m4", ["exact"], rng=np.random.default_rng(0))
    assert [run.engine for run in table.runs] == ["exact"]
    with pytest.raises(UnknownName, match="Engine 'mcmc' is unknown"):
        compare(SAID, CITY, "sloop-m4", ["exact", "mcmc"], rng=np.random.default_rng(0))
