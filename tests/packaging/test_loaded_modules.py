"""What each command loads: which packages it does without, and how many modules at most."""

import json
from collections import Counter

import pytest
from support.tree import run_python

from sloop_ppl.bridge._catalogue import CATALOGUE

TEXT = "the green toyota is behind velvet dog and near ivy"
TABLES = {"h5netcdf", "h5py", "pandas", "pyarrow", "xarray", "dask"}
NEVER = {"arviz", "numba", "osmium", "osmnx", "pomdp_py", "ray", "sympy"}
SPACY = {"spacy", "thinc"}
TORCH = {"pyro", "torch"}
DRAWN = {"matplotlib"}
BARE = TABLES | NEVER | SPACY | DRAWN
ALL = TABLES | NEVER | SPACY | TORCH | DRAWN | {"scipy"}
INFER = ("infer", TEXT, "--map", "cleveland")

# Arguments, packages that must not be loaded, and the most modules: what was counted and a tenth.
COMMANDS = {
    "help": (("--help",), ALL | {"numpy", "shapely"}, 390),
    "list maps": (("list", "maps"), ALL, 580),
    "map show": (("map", "show", "cleveland"), ALL, 650),
    "parse": (("parse", TEXT, "--map", "cleveland"), ALL, 660),
    "parse to JSON": (("parse", TEXT, "--map", "cleveland", "--json"), ALL, 650),
    "nothing to read": (("parse", "hello", "--map", "cleveland"), ALL, 660),
    "an unknown map": (("infer", TEXT, "--map", "atlantis"), BARE, 2150),
    "infer": (INFER, BARE, 2150),
    "infer to JSON": ((*INFER, "--json"), BARE, 2150),
    "infer by hand": ((*INFER, "--model", "sloop-m4"), BARE, 2150),
    "infer and export": ((*INFER, "--export", "cells.geojson"), BARE, 2150),
    "infer and draw": ((*INFER, "--figure", "belief.png"), TABLES | NEVER | SPACY, 2400),
    "infer and save": ((*INFER, "--out", "belief.nc"), NEVER | SPACY | DRAWN, 3100),
}  # fmt: skip
RUN = """
import json, sys
from sloop_ppl.cli import main
try:
    main(sys.argv[1:])
except SystemExit:
    pass
print(json.dumps(sorted(sys.modules)))
"""


def loaded(tmp_path, *arguments):
    """Return package -> how many modules of it a command loads."""
    modules = json.loads(run_python(RUN, tmp_path, *arguments).splitlines()[-1])
    return Counter(name.split(".")[0] for name in modules)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_loads_no_more_than_it_needs(tmp_path, name):
    arguments, without, most = COMMANDS[name]
    found = loaded(tmp_path, *arguments)
    assert sorted(set(found) & without) == []
    assert found.total() < most, found.most_common(20)


@pytest.mark.parametrize("what", CATALOGUE)
def test_a_list_of_names_loads_no_more_than_them(tmp_path, what):
    found = loaded(tmp_path, "list", what)
    assert sorted(set(found) & ALL) == []
    assert found.total() < 580, found.most_common(20)


def test_python_loads_no_more_than_it_needs(tmp_path):
    code = (
        "import json, sys\n"
        "import sloop_ppl as sloop\n"
        "city = sloop.load_map('cleveland')\n"
        f"said = sloop.parse({TEXT!r}, city)\n"
        "before = sorted(sys.modules)\n"
        "sloop.infer(said, city).belief('GreenToyota')\n"
        "print(json.dumps([before, sorted(sys.modules)]))\n"
    )
    told = json.loads(run_python(code, tmp_path).splitlines()[-1])
    read, inferred = (Counter(name.split(".")[0] for name in names) for names in told)
    assert sorted(set(read) & (ALL | {"typer", "rich"})) == []
    assert sorted(set(inferred) & (BARE | {"typer", "rich"})) == []
    assert (read.total() < 510, inferred.total() < 2000) == (True, True)
