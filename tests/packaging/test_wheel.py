"""The wheel is whole, and works from another folder."""

import zipfile

import pytest
from support.tree import ROOT, module_names, run_python

pytestmark = pytest.mark.xdist_group("wheel")


def test_it_holds_every_module_and_data_file(wheel):
    with zipfile.ZipFile(wheel) as archive:
        held = set(archive.namelist())
    expected = set()
    for top, inside in (
        ("sloop_ppl", "sloop_ppl"),
        ("models", "sloop_ppl/models"),
        ("inference", "sloop_ppl/inference"),
        ("eval", "sloop_ppl/eval"),
    ):
        for path in (ROOT / top).rglob("*"):
            if path.is_file() and "__pycache__" not in path.parts:
                expected.add(f"{inside}/{path.relative_to(ROOT / top).as_posix()}")
    assert sorted(expected - held) == []
    assert "sloop_ppl/py.typed" in held
    assert "sloop_ppl/data/maps/cleveland.geojson" in held
    assert "sloop_ppl/data/maps/NOTICE.md" in held
    assert "sloop_ppl/data/examples.jsonl" in held
    assert "sloop_ppl/data/kinds/osm.json" in held
    assert "sloop_ppl/data/confidence.json" in held
    assert "sloop_ppl/data/ordinary_words.txt.gz" in held


def test_it_holds_nothing_else(wheel):
    with zipfile.ZipFile(wheel) as archive:
        tops = {name.split("/")[0] for name in archive.namelist()}
    assert {t for t in tops if not t.endswith(".dist-info")} == {"sloop_ppl"}


def test_it_names_every_licence(wheel):
    with zipfile.ZipFile(wheel) as archive:
        (metadata,) = (n for n in archive.namelist() if n.endswith(".dist-info/METADATA"))
        lines = archive.read(metadata).decode().splitlines()
    assert "License-Expression: Apache-2.0" in lines
    assert "License-File: LICENSE" in lines
    assert "License-File: sloop_ppl/data/kinds/NOTICE.md" in lines
    assert "License-File: sloop_ppl/data/maps/NOTICE.md" in lines
    assert "License-File: sloop_ppl/data/ordinary_words.NOTICE.md" in lines


def test_every_module_comes_from_the_wheel_in_another_folder(site, tmp_path):
    names = [n for n in module_names() if not n.endswith("__main__")]
    code = (
        "import importlib, sys\n"
        "for name in sys.argv[1:]:\n"
        "    print(importlib.import_module(name).__file__)\n"
    )
    places = run_python(code, tmp_path, *names, site=site).split("\n")[:-1]
    assert len(places) == len(names)
    assert [p for p in places if not p.startswith(str(site))] == []


def test_it_loads_a_map_and_the_examples_in_another_folder(site, tmp_path):
    code = (
        "from sloop_ppl.maps import load_map\n"
        "from sloop_ppl.eval import bundled_examples\n"
        "print(repr(load_map('cleveland')), len(bundled_examples()))\n"
    )
    printed = run_python(code, tmp_path, site=site)
    assert printed == "CityMap('cleveland', 41 x 41 cells of 5 m, 61 landmarks) 32\n"
