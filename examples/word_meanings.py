"""What each kind of word means: one phrase a panel, under the model `bayes`.

Run: python examples/word_meanings.py [--out word_meanings.png]
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import sloop_ppl as sloop
from sloop_ppl.language import SPEAKER, Description, SpatialRelation, StreetPart, TargetObject

CITY, CAR = "cleveland", "GreenToyota"
STREET, CROSS, HOUSE = "West6thSt", "WestSaintClairAvenue", "MarionBuilding"

PHRASES = {
    "in the Marion Building": (CAR, "in", (HOUSE,), None),
    "near the Marion Building": (CAR, "near", (HOUSE,), None),
    "west of the Marion Building": (CAR, "west", (HOUSE,), None),
    "I am west of the Marion Building": (SPEAKER, "west", (HOUSE,), None),
    "in front of the Marion Building": (CAR, "front", (HOUSE,), None),
    "across from the Marion Building": (CAR, "across", (HOUSE,), None),
    "between Hoyt Block and Blair Block": (CAR, "between", ("HoytBlock", "BlairBlock"), None),
    "at the corner of Saint Clair and W 4th": (CAR, "at", (CROSS, "West4thSt"), None),
    "on West 6th Street": (CAR, "on", (STREET,), None),
    "near West 6th Street": (CAR, "near", (STREET,), None),
    "west of West 6th Street": (CAR, "west", (STREET,), None),
    "on the west side of West 6th": (CAR, "west", (STREET,), StreetPart("side", math.pi)),
    "at a corner of West 6th": (CAR, "at", (STREET,), StreetPart("corner")),
    "on West 6th, mid-block": (CAR, "on", (STREET,), StreetPart("mid-block")),
    "at the north end of West 6th": (CAR, "at", (STREET,), StreetPart("end", math.pi / 2)),
    "on the block of Hoyt Block": (CAR, "near", ("HoytBlock",), StreetPart("block")),
}


def main(out: Path) -> dict[str, sloop.Posterior]:
    """Draw the belief of each phrase into a file; return the posteriors by phrase."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    city = sloop.load_map(CITY)
    figure = Figure(figsize=(14, 14.5), layout="constrained")
    FigureCanvasAgg(figure)
    found = {}
    for axes, (text, phrase) in zip(figure.subplots(4, 4).flat, PHRASES.items(), strict=True):
        target, word, grounds, part = phrase
        relation = SpatialRelation(target, word, grounds, part=part)
        said = Description(text, CITY, (TargetObject(target),), (relation,))
        found[text] = sloop.infer(said, city)
        sloop.plots.plot_belief(
            found[text], target, ax=axes, labels=False, legend=False, colour_bar=False, title=text
        )
        axes.set(xticks=[], yticks=[], xlabel="", ylabel="")
    figure.savefig(out, dpi=70, metadata={"Software": None})
    return found


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("--out", type=Path, default=Path("word_meanings.png"))
    main(options.parse_args().out)
