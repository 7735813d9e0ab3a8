"""Find one car and learn where the other is: they were described in one frame of reference.

"In front of" depends on which way the speaker takes the house to face. The model predicts the
nearest road, the lane on its east, and is not sure. When the first car turns up on the street to
the west, this speaker's front must be the western one, and what is behind moves to the east. A
model that gives every phrase a frame of its own learns nothing from the find.

    python examples/speaker_frame.py --out speaker_frame.png
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely

import sloop_ppl as sloop
from sloop_ppl.models import PredictedSpread, preset

TEXT = (
    "The red Honda is in front of Gotham City Condos, and the green Toyota is behind "
    "Gotham City Condos."
)
FOUND, FOUND_AT = "RedHonda", (-27.5, 27.5)
SOUGHT, SOUGHT_AT = "GreenToyota", (42.5, 27.5)
# The reading is certain here: both cars share it, so that a find tells a little of it, too.
READ = replace(preset("bayes"), sum_readings=False)
BY_THE_STREET = replace(READ, frame_prior=PredictedSpread())  # nearest-street
ONE_SPEAKER = replace(BY_THE_STREET, name="bayes, one speaker", shared_frames=True)
STRANGERS = replace(BY_THE_STREET, name="bayes, a frame a phrase")


@dataclass(frozen=True)
class Result:
    """Before and after the find: P(Toyota east of the house's middle), P(front faces west)."""

    east: tuple[float, float]
    faces_west: tuple[float, float]
    east_strangers: tuple[float, float]


def main(out: Path, smoke: bool = False) -> Result:
    """Infer, find the Honda, and show what that tells of the Toyota."""
    city = sloop.load_map("denver")
    said = sloop.parse(TEXT, city)
    ground = said.relations[0].ground
    _, south, east, north = city.grid.cells_extent_m
    eastern = shapely.box(city.centroid(ground)[0], south, east, north)
    found = {FOUND: _only_at(city, FOUND_AT)}
    print(f"“{TEXT}”")
    sides = {}
    pairs = {}
    for model in (ONE_SPEAKER, STRANGERS):
        before = sloop.infer(said, city, model=model)
        pairs[model.name] = pair = before, before.condition(found)
        sides[model.name] = tuple(p.probability_in(SOUGHT, eastern) for p in pair)
        line = "P(Toyota on the eastern side) {:.2f}, once the Honda is found {:.2f}"
        print(f"{model.name}: {line.format(*sides[model.name])}")
    pair = pairs[ONE_SPEAKER.name]
    frames = [posterior.frame(SOUGHT, ground) for posterior in pair]
    west = np.cos(frames[0]["angle"].values) < -np.sqrt(0.5)
    faces = float(frames[0][west].sum()), float(frames[1][west].sum())
    print("P(the front is within 45 degrees of west) {:.2f}, then {:.2f}".format(*faces))
    _draw(pair, ground, out, dpi=50 if smoke else 95)
    return Result(sides[ONE_SPEAKER.name], faces, sides[STRANGERS.name])


def _only_at(city: sloop.CityMap, place: tuple[float, float]) -> np.ndarray:
    """Return the log likelihood of seeing a target at a place for sure."""
    seen = np.full(city.grid.shape, -np.inf)
    seen[city.grid.cell_at(*place)] = 0.0
    return seen


def _draw(
    pair: tuple[sloop.Posterior, sloop.Posterior], ground: str, out: Path, dpi: float
) -> None:
    from matplotlib.figure import Figure
    from matplotlib.patheffects import withStroke

    figure = Figure(figsize=(14.6, 5.7), layout="constrained")
    left, middle, right = figure.subplots(1, 3, width_ratios=[1, 0.72, 1])
    before, after = pair
    for ax, posterior, when in ((left, before, "before"), (right, after, "after")):
        title = f"{SOUGHT} {when} {FOUND} is found"
        sloop.plots.plot_belief(posterior, SOUGHT, ax=ax, truth=SOUGHT_AT, title=title)
    right.plot(*FOUND_AT, marker="X", ms=10, mfc="#d55e00", mec="white", zorder=6)
    right.annotate(
        f"{FOUND} was found here",
        FOUND_AT,
        xytext=(0, -9),
        textcoords="offset points",
        ha="center",
        va="top",
        fontsize=8.5,
        color="#d55e00",
        path_effects=[withStroke(linewidth=2.5, foreground="white")],
        zorder=6,
    )
    sloop.plots.plot_frame(
        after.city,
        ground,
        after.frame(SOUGHT, ground).values,
        prior=before.frame(SOUGHT, ground).values,
        ax=middle,
        legend=False,
        title="Front, before (dashed) and after the find",
    )
    figure.suptitle(f"“{TEXT}”", fontsize=11)
    sloop.plots.save_figure(figure, out, dpi=dpi)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("speaker_frame.png"))
    parser.add_argument("--smoke", action="store_true", help="draw coarsely, for tests")
    given = parser.parse_args()
    main(given.out, given.smoke)
