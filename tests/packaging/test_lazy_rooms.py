"""Rooms whose names load on first use: each is there, and is what its home defines."""

import ast
from importlib import import_module

import pytest
from support.tree import ROOT, ROOTS

ROOMS = ("bridge", "eval", "inference", "language", "models", "planning", "simulation", "web")


@pytest.mark.parametrize("room", ROOMS)
def test_every_name_is_there(room):
    module = import_module(f"sloop_ppl.{room}")
    assert set(module.__all__) <= set(dir(module))
    for name in module.__all__:
        assert getattr(module, name) is not None
    with pytest.raises(AttributeError, match=f"module 'sloop_ppl.{room}' has no attribute 'wh"):
        _ = module.whatever


@pytest.mark.parametrize("room", ["eval", "inference", "models", "simulation", "web"])
def test_the_homes_hold_the_names_and_no_others(room):
    module = import_module(f"sloop_ppl.{room}")
    listed = [name for names in module._HOMES.values() for name in names]
    assert sorted(listed) == sorted(module.__all__)
    for home, names in module._HOMES.items():
        assert home not in module.__all__  # else the module would take the name's place
        for name in names:
            assert getattr(module, name) is getattr(import_module(f"sloop_ppl.{room}.{home}"), name)


@pytest.mark.parametrize("room", ["eval", "inference", "models"])
def test_modules_without_public_names_start_with_an_underscore(room):
    homes = set(import_module(f"sloop_ppl.{room}")._HOMES)
    folder = ROOTS[f"sloop_ppl.{room}"]
    plain = {path.stem for path in folder.glob("*.py") if not path.stem.startswith("_")}
    # `python -m sloop_ppl.inference.calibration` is a command of the docs.
    assert plain - homes == ({"calibration"} if room == "inference" else set())


@pytest.mark.parametrize(
    "room", ["bridge", "cli", "maps", "maps.osm", "plots", "simulation", "web"]
)
def test_modules_that_the_room_does_not_import_start_with_an_underscore(room):
    folder = ROOT.joinpath("sloop_ppl", *room.split("."))
    tree = ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    homes = {node.module.rpartition(".")[2] for node in imports}
    plain = {path.stem for path in folder.glob("*.py") if not path.stem.startswith("_")}
    assert plain <= homes
