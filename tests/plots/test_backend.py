"""A backend of a notebook in the environment neither breaks figures nor is lost where it is."""

import os
import subprocess
import sys

import pytest

from sloop_ppl._figure_backend import forget_missing_backend


@pytest.mark.parametrize(
    ("named", "kept"),
    [
        ("module://absent_package.backend_inline", None),
        ("module://sloop_ppl.absent", None),
        ("module://matplotlib.backends.backend_agg", "module://matplotlib.backends.backend_agg"),
        ("agg", "agg"),
        ("TkAgg", "TkAgg"),
        ("notebook", "notebook"),
        ("nonsense", None),
        ("x" * 300, None),
    ],
)
def test_only_a_backend_that_is_not_there_is_forgotten(monkeypatch, named, kept):
    monkeypatch.setenv("MPLBACKEND", named)
    forget_missing_backend()
    assert os.environ.get("MPLBACKEND") == kept


@pytest.mark.parametrize("backend", ["module://absent_package.backend_inline", "absent"])
def test_a_figure_is_drawn_under_the_backend_of_a_notebook(tmp_path, backend):
    code = (
        "from sloop_ppl import load_map\n"
        "from sloop_ppl.plots import plot_map, save_figure\n"
        f"save_figure(plot_map(load_map('cleveland')), {str(tmp_path / 'm.svg')!r})"
    )
    env = {**os.environ, "MPLBACKEND": backend}
    done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    assert (tmp_path / "m.svg").stat().st_size > 1000
