"""Tables as Markdown, LaTeX and CSV."""

import csv
import html
import io
import re

import pytest

from sloop_ppl.eval import _report
from sloop_ppl.eval._tables import Estimate, Table

TABLE = Table(
    "small",
    "A small table, 100 %",
    ("model", "n", "reward", "note_1"),
    (
        ("first group", None, None, None),
        ("a_b", 3, Estimate(-0.4, -12.0, 7.25), "x|y"),
        ("c", 12, Estimate(2.0), None),
    ),
    ("How to read it.",),
)


def test_markdown():
    assert TABLE.markdown().splitlines() == [
        "| model | n | reward | note_1 |",
        "| --- | ---: | ---: | --- |",
        "| **first group** |  |  |  |",
        "| a_b | 3 | 0 [−12, 7] | x\\|y |",
        "| c | 12 | 2 |  |",
        "",
        "How to read it.",
    ]


def test_latex_is_escaped():
    told = TABLE.latex()
    assert r"\caption{A small table, 100 \%}" in told
    assert r"\begin{tabular}{lrrl}" in told
    assert r"\multicolumn{4}{l}{\emph{first group}} \\" in told
    assert r"a\_b & 3 & 0 [$-$12, 7] & x|y \\" in told


def test_csv_has_a_column_for_each_end():
    rows = list(csv.reader(io.StringIO(TABLE.csv())))
    assert rows == [
        ["model", "n", "reward", "reward low", "reward high", "note_1"],
        ["a_b", "3", "-0.4", "-12.0", "7.25", "x|y"],
        ["c", "12", "2.0", "", "", ""],
    ]


def test_digits():
    assert Estimate(-1.234, -2.0, -0.001, digits=2).text() == "−1.23 [−2.00, 0.00]"


HOSTILE = (
    "<img src=x onerror=alert(1)>",
    "\\<script>alert(1)</script>",
    "![p](http://example.org/p.png)",
    "[click](http://example.org)",
    "a | b <b>c</b>",
    "one\n\n<iframe></iframe>",
    "<http://example.org>",
)


@pytest.mark.parametrize("name", HOSTILE)
def test_no_html_of_a_name_survives_in_a_report(name):
    table = Table("t", name, ("model", name), ((name, 1.0), (name, None)), ())
    picture = _report.Picture("p", f"The worst trial of {name}", lambda: None)
    report = _report.Report(name, (table, picture))
    page = _report._page(report.title, report.markdown("figures"))
    tags = set(re.findall(r"<\s*/?\s*([a-zA-Z]+)", page.partition("<body>")[2]))
    assert not tags & {"script", "iframe", "a", "b"}
    assert page.count("<img") == 1
    assert '<img src="figures/p.png"' in page
    shown = html.unescape(page)
    assert " ".join(name.split()) in " ".join(shown.split())


@pytest.mark.parametrize(
    ("cell", "written"),
    [
        ("=HYPERLINK(1)", "'=HYPERLINK(1)"),
        ("+cmd", "'+cmd"),
        ("@SUM(A1)", "'@SUM(A1)"),
        (" =1+1", "' =1+1"),
        ("-0.25", "-0.25"),
        ("near", "near"),
        (-3.5, "-3.5"),
    ],
)
def test_no_cell_of_a_csv_is_a_formula(cell, written):
    text = Table("t", "T", ("name", "n"), ((cell, 1), ("b", 2)), ()).csv()
    assert list(csv.reader(io.StringIO(text)))[1][0] == written
