"""Find the phrase that is wrong among three, and the car in spite of it.

The speaker says "West 4th Street" and means another. No place fits all three phrases, so a product
of relations believes in a place that fits none of them well. A model in which every phrase may be
a slip has a latent lapse for each; their posterior names the phrase that is probably wrong, and
the belief follows the other two.

    python examples/mistaken_phrase.py --out mistaken_phrase.png
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import sloop_ppl as sloop
from sloop_ppl.bridge import relations_in_words
from sloop_ppl.models import preset

TEXT = "The green Toyota is near Velvet Dog, west of Hoyt Block and on West 4th Street."
TARGET, TRUTH = "GreenToyota", (-37.5, -57.5)
WARY = replace(preset("bayes"), name="bayes with lapses", lapse=0.1)


@dataclass(frozen=True)
class Result:
    """What came of it: the wrong phrase's probability, and how far each model is off, metres."""

    suspected: str
    p_wrong: dict[str, float]
    error_m: dict[str, float]
    log_score: dict[str, float]


def main(out: Path, smoke: bool = False) -> Result:
    """Infer with SLOOP's product and with lapses, print the comparison, and draw it."""
    city = sloop.load_map("cleveland")
    said = sloop.parse(TEXT, city)
    posteriors = {
        "SLOOP's product": sloop.infer(said, city, model="sloop"),
        "with a lapse for each phrase": sloop.infer(said, city, model=WARY),
    }
    words = relations_in_words(posteriors["SLOOP's product"], TARGET)
    lapses = posteriors["with a lapse for each phrase"].lapses(TARGET)
    p_wrong = {words[lapse.index]: lapse.p for lapse in lapses}
    prior = {words[lapse.index]: lapse.prior for lapse in lapses}
    suspected = max(p_wrong, key=lambda phrase: p_wrong[phrase])
    print(f"“{TEXT}”")
    for phrase, p in p_wrong.items():
        print(f"  “{phrase}” is wrong with probability {p:.2f} (was {prior[phrase]:.2f})")
    errors, scores = {}, {}
    row, col = city.grid.cell_at(*TRUTH)
    for name, posterior in posteriors.items():
        errors[name] = math.dist(posterior.mode(TARGET), TRUTH)
        scores[name] = math.log(posterior.belief(TARGET)[row, col])
        print(
            f"{name}: most probable cell {errors[name]:.0f} m off, "
            f"log belief at the true cell {scores[name]:.1f}"
        )
    _draw(posteriors, p_wrong, prior, out, dpi=50 if smoke else 95)
    return Result(suspected, p_wrong, errors, scores)


def _draw(
    posteriors: dict[str, Any],
    p_wrong: dict[str, float],
    prior: dict[str, float],
    out: Path,
    dpi: float,
) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(14.0, 5.6), layout="constrained")
    *maps, bars = figure.subplots(1, 3, width_ratios=[1, 1, 0.62])
    for ax, (name, posterior) in zip(maps, posteriors.items(), strict=True):
        sloop.plots.plot_belief(posterior, TARGET, ax=ax, truth=TRUTH, title=name)
    sloop.plots.plot_components(p_wrong, prior=prior, ax=bars, title="Which phrase is wrong?")
    bars.set_xlabel("probability that the phrase is wrong (%)")
    figure.suptitle(f"“{TEXT}”", fontsize=11)
    sloop.plots.save_figure(figure, out, dpi=dpi)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("mistaken_phrase.png"))
    parser.add_argument("--smoke", action="store_true", help="draw coarsely, for tests")
    given = parser.parse_args()
    main(given.out, given.smoke)
