"""What is imported when, under which name: asked of fresh processes in another folder."""

import importlib.util
import json

import pytest
from support.tree import module_names, run_python

HEAVY = (
    "torch", "pyro", "spacy", "matplotlib.pyplot", "pomdp_py", "osmium", "osmnx", "numba", "arviz",
    "scipy", "xarray", "pyproj", "shapely", "mujoco",
)  # fmt: skip

LOADED = "import json, sys; print(json.dumps(sorted(sys.modules)))"


def test_importing_the_package_loads_nothing_heavy(tmp_path):
    loaded = json.loads(run_python(f"import sloop_ppl; {LOADED}", tmp_path).splitlines()[-1])
    assert sorted(set(loaded) & set(HEAVY)) == []


@pytest.mark.skipif(
    importlib.util.find_spec("sloop_ppl.cli") is None, reason="there is no command line yet"
)
@pytest.mark.parametrize("arguments", [["--help"], ["search", "--help"], ["--version"]])
def test_help_loads_nothing_heavy(tmp_path, arguments):
    code = (
        "import sys\n"
        "from sloop_ppl.cli import main\n"
        f"sys.argv = ['sloop', *{arguments!r}]\n"
        "try:\n"
        "    code = main()\n"
        "except SystemExit as leaving:\n"
        "    code = leaving.code\n"
        "assert not code, code\n" + LOADED
    )
    loaded = json.loads(run_python(code, tmp_path).splitlines()[-1])
    assert sorted(set(loaded) & set(HEAVY)) == []


@pytest.mark.parametrize("room", ["maps", "language", "plots", "planning", "simulation"])
def test_a_room_costs_no_torch_nor_spacy(tmp_path, room):
    loaded = json.loads(run_python(f"import sloop_ppl.{room}; {LOADED}", tmp_path).splitlines()[-1])
    assert sorted(set(loaded) & {"torch", "pyro", "spacy", "matplotlib.pyplot", "numba"}) == []


def test_top_level_folders_are_never_modules_of_their_own(tmp_path):
    names = [n for n in module_names() if not n.endswith("__main__")]
    code = (
        "import importlib, json, sys\n"
        "for name in sys.argv[1:]:\n"
        "    importlib.import_module(name)\n" + LOADED
    )
    loaded = json.loads(run_python(code, tmp_path, *names).splitlines()[-1])
    assert set(names) <= set(loaded)
    assert sorted(set(loaded) & {"models", "inference", "eval"}) == []
