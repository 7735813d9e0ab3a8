"""A phrase and its denial: what "near Ivy" and "not near Ivy" say of the map.

Run: python examples/denied_phrase.py [--out denied_phrase.png]
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import sloop_ppl as sloop
from sloop_ppl.models import preset

TEXTS = ("The red bike is near Ivy.", "The red bike is not near Ivy.")
TARGET, GROUND = "RedBike", "Ivy"
NEAR_M = 15.0
MODEL = replace(preset("bayes"), sum_readings=False)  # as it was read, for certain


def main(out: Path) -> dict[str, float]:
    """Draw both beliefs into a file; return by text the belief within 15 m of the ground."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    city = sloop.load_map("cleveland")
    near = city.fields(GROUND).distance_m <= NEAR_M
    figure = Figure(figsize=(11, 5), layout="constrained")
    FigureCanvasAgg(figure)
    found = {}
    for axes, text in zip(figure.subplots(1, len(TEXTS)), TEXTS, strict=True):
        posterior = sloop.infer(sloop.parse(text, city), city, MODEL)
        found[text] = float(posterior.belief(TARGET)[near].sum())
        title = f"“{text}” {found[text]:.3f} within {NEAR_M:g} m"
        sloop.plots.plot_belief(posterior, TARGET, ax=axes, legend=False, title=title)
    figure.savefig(out, dpi=90, metadata={"Software": None})
    return found


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("--out", type=Path, default=Path("denied_phrase.png"))
    main(options.parse_args().out)
