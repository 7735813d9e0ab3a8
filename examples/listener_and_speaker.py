"""One description to a listener, to one who tempers nothing, and to the speaker's own model.

Run: python examples/listener_and_speaker.py [--out listener_and_speaker.png]
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import sloop_ppl as sloop
from sloop_ppl.models import preset, speaker_of

TEXT = "The red bike is near Velvet Dog, near Rumor and south of Ball Building."
TARGET = "RedBike"
MODELS = {
    "bayes, a listener": preset("bayes"),
    "bayes with temper 0": replace(preset("bayes"), temper=0.0),
    "bayes as a speaker": speaker_of("bayes"),
}


def main(out: Path) -> dict[str, float]:
    """Draw the beliefs into a file; return the entropy of each, nats."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    city = sloop.load_map("cleveland")
    said = sloop.parse(TEXT, city)
    figure = Figure(figsize=(16, 5), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(f"“{TEXT}”")
    entropies = {}
    for axes, (name, model) in zip(figure.subplots(1, len(MODELS)), MODELS.items(), strict=True):
        posterior = sloop.infer(said, city, model=model)
        entropies[name] = posterior.entropy(TARGET)
        title = f"{name}: {entropies[name]:.2f} nats"
        sloop.plots.plot_belief(posterior, TARGET, ax=axes, legend=False, title=title)
    figure.savefig(out, dpi=80, metadata={"Software": None})
    return entropies


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("--out", type=Path, default=Path("listener_and_speaker.png"))
    main(options.parse_args().out)
