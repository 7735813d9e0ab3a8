"""CITATION.cff has what its format requires, and says what pyproject.toml says."""

from __future__ import annotations

import re
import tomllib

import pytest
from support.tree import ROOT

import sloop_ppl

yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]

# Of the schema of the Citation File Format 1.2.0
REQUIRED = {"authors", "cff-version", "message", "title"}
KNOWN = REQUIRED | {
    "abstract", "commit", "contact", "date-released", "doi", "identifiers", "keywords", "license",
    "license-url", "preferred-citation", "references", "repository", "repository-artifact",
    "repository-code", "type", "url", "version",
}  # fmt: skip


def test_it_has_what_the_format_requires_and_nothing_unknown():
    assert set(CITATION) >= REQUIRED
    assert set(CITATION) <= KNOWN
    assert CITATION["cff-version"] == "1.2.0"
    assert CITATION["type"] == "software"
    for author in CITATION["authors"]:
        assert set(author) <= {"name", "family-names", "given-names", "orcid", "affiliation"}
        assert author.keys() & {"name", "family-names"}


def test_the_paper_is_a_reference_with_all_its_authors():
    (paper,) = CITATION["references"]
    assert {"authors", "title", "type"} <= set(paper)
    names = [author["family-names"] for author in paper["authors"]]
    assert names == ["Zheng", "Bayazit", "Mathew", "Pavlick", "Tellex"]
    assert paper["title"] in " ".join((ROOT / "README.md").read_text().split())
    assert paper["year"] == 2021


def test_it_agrees_with_the_package():
    assert CITATION["version"] == PROJECT["version"] == sloop_ppl.__version__
    assert CITATION["license"] == PROJECT["license"]
    assert CITATION["repository-code"] == PROJECT["urls"]["Source"]
    assert CITATION["url"] == PROJECT["urls"]["Documentation"]


def test_there_is_one_address_of_the_repository():
    source = PROJECT["urls"]["Source"]
    for name in ("CITATION.cff", "README.md", "mkdocs.yml", "docs/citing.md"):
        text = (ROOT / name).read_text(encoding="utf-8")
        found = set(re.findall(r"https://github\.com/sloop-ppl/[\w-]+", text))
        assert found == {source}, name
