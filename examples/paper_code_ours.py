"""One sentence under the paper's text, its published code, and our model, side by side.

python examples/paper_code_ours.py --out paper_code_ours.png
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import sloop_ppl as sloop
from sloop_ppl.models import ObservationModel, preset

TEXT = "The green Toyota is behind Velvet Dog and near West Saint Clair Avenue."
TARGET = "GreenToyota"
MODELS: dict[str, ObservationModel] = {
    "the paper's text": preset("sloop-m4", variant="paper"),
    "its published code": preset("sloop-m4"),
    "ours (bayes)": preset("bayes"),
}


def main(out: Path) -> dict[str, np.ndarray]:
    """Draw the three beliefs into a file; return them by name, shape (H, W) each."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    city = sloop.load_map("cleveland")
    said = sloop.parse(TEXT, city)
    figure = Figure(figsize=(14, 5), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(f"“{TEXT}”")
    beliefs = {}
    for axes, (name, model) in zip(figure.subplots(1, 3), MODELS.items(), strict=True):
        posterior = sloop.infer(said, city, model=model)
        beliefs[name] = posterior.belief(TARGET)
        title = f"{name}: {posterior.entropy(TARGET):.2f} nats"
        sloop.plots.plot_belief(posterior, TARGET, ax=axes, legend=False, title=title)
    figure.savefig(out, dpi=90, metadata={"Software": None})
    return beliefs


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("--out", type=Path, default=Path("paper_code_ours.png"))
    main(options.parse_args().out)
