"""Tables as Markdown, LaTeX and CSV."""

import csv
import io

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
