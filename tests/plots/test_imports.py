from __future__ import annotations

import subprocess
import sys


def test_importing_plots_loads_nothing_heavy() -> None:
    code = (
        "import sys, sloop_ppl.plots; "
        "heavy = {'torch', 'pyro', 'spacy', 'pomdp_py', 'xarray', 'matplotlib.pyplot', 'PIL'}; "
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_drawing_on_given_axes_never_loads_pyplot() -> None:
    code = (
        "import sys; from matplotlib.figure import Figure; from sloop_ppl.maps import load_map; "
        "from sloop_ppl.plots import plot_map; "
        "plot_map(load_map('austin'), ax=Figure().add_subplot()).figure.canvas.draw(); "
        "print('matplotlib.pyplot' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
