"""The list of packages is written by hand; here it is held against the folders."""

import tomllib

from support.tree import ROOT, package_names

SETUPTOOLS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]


def test_packages_are_the_folders_with_an_init():
    assert sorted(SETUPTOOLS["packages"]) == package_names()
    assert SETUPTOOLS["packages"] == sorted(SETUPTOOLS["packages"])


def test_the_top_level_folders_are_mapped_into_the_one_package():
    assert SETUPTOOLS["package-dir"] == {
        "sloop_ppl": "sloop_ppl",
        "sloop_ppl.models": "models",
        "sloop_ppl.inference": "inference",
        "sloop_ppl.eval": "eval",
    }


def test_no_folder_of_modules_lacks_an_init():
    folders = {p.parent for name in ("sloop_ppl", "models", "inference", "eval")
               for p in (ROOT / name).rglob("*.py")}  # fmt: skip
    assert [str(f) for f in sorted(folders) if not (f / "__init__.py").exists()] == []
