"""Run the notebooks of ``examples/`` and write them as pages with what they print and draw.

Run: python docs/site_tools/tutorials.py [NAME ...]

A notebook is a Python file in jupytext's percent format: cells begin with ``# %%``. It opens in
Jupyter with jupytext, and runs as a plain script. SLOOP_QUICK=1 makes the runs shorter.
"""

from __future__ import annotations

import ast
import contextlib
import io
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import matplotlib

__all__ = ["Cell", "cells_of", "page_of", "run_cells"]

ROOT = Path(__file__).parents[2]
NOTEBOOKS = ROOT / "examples" / "notebooks"
PAGES = ROOT / "docs" / "tutorials"
PICTURES = ROOT / "docs" / "images" / "tutorials"


@dataclass(frozen=True)
class Cell:
    """A cell of a notebook: text in Markdown, or code."""

    text: str
    is_code: bool


def cells_of(path: Path) -> list[Cell]:
    """Return the cells of a notebook in percent format, without its header."""
    _, *pieces = re.split(r"^# %%", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    cells = []
    for piece in pieces:
        mark, _, text = piece.partition("\n")
        if "[markdown]" in mark:
            lines = [line.removeprefix("#").removeprefix(" ") for line in text.strip().splitlines()]
            cells.append(Cell("\n".join(lines), is_code=False))
        else:
            cells.append(Cell(text.strip(), is_code=True))
    return cells


def run_cells(cells: list[Cell], name: str) -> Iterator[tuple[Cell, str, list[bytes]]]:
    """Run the code of a notebook; yield each cell, what it printed, and the pictures it left.

    Parameters
    ----------
    cells
        All cells, in order.
    name
        Of the notebook, for messages.
    """
    matplotlib.use("agg")
    module = ModuleType(f"notebook_{name}")
    sys.modules[module.__name__] = module  # dataclasses look their module up
    for number, cell in enumerate(cells):
        if not cell.is_code:
            yield cell, "", []
            continue
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            last = _run(cell.text, f"{name}, cell {number}", module.__dict__)
        yield cell, printed.getvalue(), _pictures(last)


def _run(code: str, where: str, names: dict[str, object]) -> object:
    """Run code as a notebook does, and return the value of its last line if that is one."""
    tree = ast.parse(code)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, where, "exec"), names)
    if last is None:
        return None
    return eval(compile(ast.Expression(last.value), where, "eval"), names)


def _pictures(last: object) -> list[bytes]:
    """Return the figures that pyplot holds, and that of a last line, as PNG."""
    from matplotlib import pyplot as plt
    from matplotlib.figure import Figure

    figures = [plt.figure(number) for number in plt.get_fignums()]
    if isinstance(last, Figure) and last not in figures:
        figures.append(last)
    drawn = []
    for figure in figures:
        out = io.BytesIO()
        figure.savefig(out, format="png", dpi=80)
        drawn.append(out.getvalue())
    plt.close("all")
    return drawn


def page_of(name: str) -> tuple[str, dict[str, bytes]]:
    """Run a notebook and return its page in Markdown, and its pictures by file name."""
    parts, pictures = [], {}
    for cell, printed, drawn in run_cells(cells_of(NOTEBOOKS / f"{name}.py"), name):
        parts.append(f"```python\n{cell.text}\n```" if cell.is_code else cell.text)
        if printed:
            parts.append(f"```text\n{printed.rstrip()}\n```")
        for picture in drawn:
            file = f"{name}_{len(pictures) + 1}.png"
            pictures[file] = picture
            parts.append(f"![{_title(parts)}](../images/tutorials/{file})")
        if parts[0] == cell.text:
            source = f"../../examples/notebooks/{name}.py"
            parts.append(f"*This page is the notebook [`{name}.py`]({source}), run as it stands.*")
    return "\n\n".join(parts) + "\n", pictures


def _title(parts: list[str]) -> str:
    """Return the last heading, as the words of a picture for who does not see it."""
    return re.findall(r"^#+ (.*)$", "\n".join(parts), re.MULTILINE)[-1]


def main() -> None:
    """Write the pages of the notebooks that are named, or of all."""
    for name in sys.argv[1:] or sorted(path.stem for path in NOTEBOOKS.glob("*.py")):
        text, pictures = page_of(name)
        PICTURES.mkdir(parents=True, exist_ok=True)
        for file, picture in pictures.items():
            (PICTURES / file).write_bytes(picture)
        (PAGES / f"{name}.md").write_text(text, encoding="utf-8")
        sys.stderr.write(f"{name}: {len(pictures)} pictures\n")


if __name__ == "__main__":
    main()
