"""What an extra installs is asked for in one line, and nothing of the core needs it."""

from __future__ import annotations

import tomllib
from importlib.metadata import packages_distributions

import pytest
from support.tree import ROOT, run_python

from sloop_ppl import _extras
from sloop_ppl.errors import InputError

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
BLOCKED = """
import sys

class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"spacy", "thinc", "pyarrow", "arviz", "starlette", "mkdocs"}:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Blocked())
"""


@pytest.fixture
def no_extra(monkeypatch):
    monkeypatch.setattr(_extras, "find_spec", lambda name: None)


def test_a_missing_package_is_one_line(no_extra):
    with pytest.raises(InputError) as refused:
        _extras.need_extra("Parser 'p'", "spacy", "spacy")
    assert str(refused.value) == (
        "Parser 'p' needs spacy, which is not installed; run pip install 'sloop-ppl[spacy]'"
    )


def test_every_way_to_spacy_asks_first(no_extra):
    import sloop_ppl as sloop
    from sloop_ppl import language

    said = sloop.parse("The red bike is near Ivy.", "cleveland")
    with pytest.raises(InputError, match=r"^A page of a sentence needs spacy, .*\[spacy\]'$"):
        language.html_page(said)
    with pytest.raises(InputError, match=r"^Parser 'dependency_paths' needs spacy"):
        sloop.parse("The red bike is near Ivy.", "cleveland", parser="dependency_paths")
    for name in ("load_pipeline", "dependency_parser"):
        with pytest.raises(InputError, match=f"^{name} needs spacy"):
            getattr(language, name)


def test_a_sweep_without_its_table_does_not_begin(no_extra, tmp_path):
    from sloop_ppl.eval._sweep_files import SweepRequest, sweep_files

    request = SweepRequest((tmp_path / "said.jsonl",), tmp_path / "run")
    with pytest.raises(InputError, match=r"^The table of trials of a sweep needs pyarrow"):
        sweep_files(request)
    assert not (tmp_path / "run").exists()


def test_every_extra_that_is_asked_for_is_declared():
    extras = PROJECT["optional-dependencies"]
    assert [d for d in PROJECT["dependencies"] if d.startswith(("spacy", "pyarrow"))] == []
    assert extras["spacy"] == ["spacy>=3.8,<3.9"]
    assert extras["sweep"] == ["pyarrow>=18"]
    for name in ("docs", "spacy", "sweep"):
        assert set(extras[name]) <= set(extras["dev"]), name


def test_the_core_runs_without_any_extra(tmp_path):
    code = BLOCKED + (
        "import numpy as np\n"
        "import sloop_ppl as sloop\n"
        "from sloop_ppl.cli import main\n"
        "city = sloop.load_map('cleveland', cell_m=20)\n"
        "post = sloop.infer('the green toyota is behind velvet dog', city)\n"
        "rng = np.random.default_rng(0)\n"
        "places = {'GreenToyota': (-47.5, -62.5)}\n"
        "run = sloop.search(post, city, places, planner='greedy', rng=rng)\n"
        "post.save('p.nc')\n"
        "sloop.plots.save_figure(sloop.bridge.figure_of(post), 'p.png')\n"
        "print(run.found, sorted({'spacy', 'pyarrow'} & set(sys.modules)))\n"
    )
    assert run_python(code, tmp_path) == "True []\n"


@pytest.mark.parametrize("package", ["torch", "numba", "pomdp_py", "scipy", "osmium"])
def test_what_is_imported_by_the_core_is_a_dependency(package):
    (distribution,) = set(packages_distributions()[package])
    asked = [d.split(">")[0].split("<")[0].lower() for d in PROJECT["dependencies"]]
    assert distribution.lower() in asked
