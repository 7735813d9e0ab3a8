"""A table as a value, and the same table as Markdown, LaTeX and CSV."""

from __future__ import annotations

import csv
import io
import math
import re
from dataclasses import dataclass
from typing import TypeAlias

__all__ = ["Cell", "Estimate", "Table", "literal"]


@dataclass(frozen=True)
class Estimate:
    """A number with its interval.

    Parameters
    ----------
    mean
        The number.
    low, high
        Ends of the interval; not a number where there is none.
    digits
        After the decimal point.
    """

    mean: float
    low: float = math.nan
    high: float = math.nan
    digits: int = 0

    def text(self) -> str:
        """Return it in words, such as ``"12 [9, 15]"``."""
        mean, low, high = (f"{v:z.{self.digits}f}" for v in (self.mean, self.low, self.high))
        return _minus(f"{mean} [{low}, {high}]" if self.bounded else mean)

    @property
    def bounded(self) -> bool:
        """Whether it has an interval."""
        return math.isfinite(self.low)


Cell: TypeAlias = str | int | float | Estimate | None
"""What a table holds; None for nothing."""


@dataclass(frozen=True)
class Table:
    """A table.

    Parameters
    ----------
    name
        Name of its files.
    title
        What it shows.
    head
        Names of the columns, the first that of the rows.
    rows
        The cells, as many a row as there are columns. A row whose cells are all empty but the first
        is the heading of those below it.
    notes
        How to read it, a sentence or two each.
    """

    name: str
    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    notes: tuple[str, ...] = ()

    def texts(self) -> list[list[str]]:
        """Return the cells of each row in words."""
        return [[_text(cell) for cell in row] for row in self.rows]

    def numeric(self) -> list[bool]:
        """Return for each column whether it is set to the right: all in it begins like a number.

        The first never is.
        """
        texts = [[cell for cell in column if cell] for column in zip(*self.texts(), strict=True)]
        signs = "0123456789−.<"
        return [
            bool(i and texts[i]) and all(c[0] in signs for c in texts[i]) for i in range(len(texts))
        ]

    def markdown(self) -> str:
        """Return it as Markdown, the notes below."""
        lines = [
            "| " + " | ".join(map(_in_table, self.head)) + " |",
            "|" + "".join(" ---: |" if right else " --- |" for right in self.numeric()),
        ]
        for row, texts in zip(self.rows, self.texts(), strict=True):
            cells = list(map(_in_table, texts))
            if _is_heading(row):
                cells[0] = f"**{cells[0]}**"
            lines.append("| " + " | ".join(cells) + " |")
        notes = [f"\n{' '.join(self.notes)}"] if self.notes else []
        return "\n".join([*lines, *notes])

    def latex(self) -> str:
        """Return it as a LaTeX table that needs the package booktabs."""
        columns = "".join("r" if right else "l" for right in self.numeric())
        lines = [
            r"\begin{table}",
            r"\centering",
            rf"\caption{{{_tex(self.title)}}}",
            rf"\begin{{tabular}}{{{columns}}}",
            r"\toprule",
            " & ".join(map(_tex, self.head)) + r" \\",
            r"\midrule",
        ]
        for row, texts in zip(self.rows, self.texts(), strict=True):
            cells = list(map(_tex, texts))
            if _is_heading(row):
                cells = [rf"\multicolumn{{{len(self.head)}}}{{l}}{{\emph{{{cells[0]}}}}}"]
            lines.append(" & ".join(cells) + r" \\")
        return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", r"\end{table}", ""])

    def csv(self) -> str:
        """Return it as CSV, with a column for each end of an interval.

        A text that a spreadsheet would take for a formula has an apostrophe before it.
        """
        body = [row for row in self.rows if not _is_heading(row)]
        wide = [any(_is_bounded(row[i]) for row in body) for i in range(len(self.head))]
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(
            _no_formula(name)
            for head, ends in zip(self.head, wide, strict=True)
            for name in ((head, f"{head} low", f"{head} high") if ends else (head,))
        )
        for row in body:
            cells: list[object] = []
            for cell, ends in zip(row, wide, strict=True):
                if isinstance(cell, Estimate):
                    numbers = (cell.mean, cell.low, cell.high)
                    cells += map(_number, numbers if ends else numbers[:1])
                else:
                    cells += [
                        "" if cell is None else _no_formula(cell),
                        *(["", ""] if ends else []),
                    ]
            writer.writerow(cells)
        return text.getvalue()


def literal(text: str) -> str:
    r"""Return a text that Markdown shows as it is, on one line: neither tags, links nor pictures.

    Examples
    --------
    >>> print(literal("<img src=x>, ![a](b), 12 [9, 15]"))
    \<img src=x>, ![a]\(b), 12 [9, 15]
    """
    text = " ".join(text.split()).replace("\\", "\\\\")
    return re.sub(r"<(?=[A-Za-z/!?])|(?<=\])[(\[]", lambda found: f"\\{found[0]}", text)


def _in_table(text: str) -> str:
    return literal(text).replace("|", "\\|")


def _no_formula(cell: str | float) -> str | float:
    if not isinstance(cell, str) or not cell.lstrip(" ").startswith(
        ("=", "+", "-", "@", "\t", "\r")
    ):
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell


def _is_heading(row: tuple[Cell, ...]) -> bool:
    return len(row) > 1 and all(cell is None for cell in row[1:])


def _is_bounded(cell: Cell) -> bool:
    return isinstance(cell, Estimate) and cell.bounded


def _text(cell: Cell) -> str:
    if cell is None:
        return ""
    if isinstance(cell, Estimate):
        return cell.text()
    if isinstance(cell, float):
        return _minus(f"{cell:g}")
    return str(cell)


def _minus(number: str) -> str:
    return number.replace("-", "−")


def _number(value: float) -> object:
    return round(value, 6) if math.isfinite(value) else ""


_TEX = {
    **{sign: rf"\{sign}" for sign in "&%_#${}"},
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "−": "$-$",
    "±": r"$\pm$",
    "×": r"$\times$",
}


def _tex(text: str) -> str:
    return "".join(_TEX.get(sign, sign) for sign in text)
