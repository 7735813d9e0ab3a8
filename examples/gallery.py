"""Draw every plot of the package, one function each, and write the gallery of the documentation.

Run: python examples/gallery.py [--out docs]

`docs/gallery.md` has a thumbnail of each picture and the lines that drew it, all of them on one
city, one sentence and one search.
"""

from __future__ import annotations

import argparse
import inspect
import textwrap
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from PIL import Image

import sloop_ppl as sloop
from sloop_ppl import plots
from sloop_ppl.bridge import relations_in_words
from sloop_ppl.models.frames import (
    context_image,
    load_weights,
    predict_frames,
    shipped_weights,
)

TEXT = "The green Toyota is behind Velvet Dog, near West 6th Street and west of Hoyt Block."
TWO = "The green Toyota is behind Velvet Dog, and the red bike is on West 4th Street."
PLACES = {"GreenToyota": (-47.5, -62.5)}
CAR = "GreenToyota"
city = sloop.load_map("cleveland")


@cache
def post() -> sloop.Posterior:
    """Return the posterior of one sentence."""
    return sloop.infer(TEXT, city)


@cache
def episode() -> sloop.Episode:
    """Return a search with it."""
    rng = np.random.default_rng(0)
    return sloop.search(post(), city, PLACES, start=(72.5, 62.5, 180.0), rng=rng)


def city_map(path: Path) -> None:
    """Show a map: landmarks by kind, with names."""
    plots.save_figure(plots.plot_map(city, highlight=["VelvetDog"]), path)


def blocks(path: Path) -> None:
    """Show streets, crossings and the blocks between them."""
    plots.save_figure(plots.plot_blocks(city), path)


def belief(path: Path) -> None:
    """Show where one target is believed to be."""
    ax = plots.plot_belief(post(), CAR, truth=PLACES[CAR])
    plots.save_figure(ax, path)


def beliefs(path: Path) -> None:
    """Show all targets of a posterior."""
    plots.save_figure(plots.plot_beliefs(sloop.infer(TWO, city)), path)


def relations(path: Path) -> None:
    """Show what each phrase says by itself, and all of them together."""
    words = relations_in_words(post(), CAR)
    parts = dict(zip(words, post().phrase_tables(CAR), strict=True))
    plots.save_figure(plots.plot_relations(city, parts, whole=post().belief(CAR)), path)


def change(path: Path) -> None:
    """Show what one more sentence changes."""
    after = post().update(sloop.parse("The green Toyota is near Hoyt Block.", city))
    ax = plots.plot_change(city, post().belief(CAR), after.belief(CAR))
    plots.save_figure(ax, path)


def sheet(path: Path) -> None:
    """Show all that explains a belief (`figure_of` gathers it)."""
    plots.save_figure(sloop.bridge.figure_of(post(), PLACES), path)


def one_sheet(path: Path) -> None:
    """Show a sheet of parts that one picks."""
    influence = {i.relation.relation: i.bits for i in post().influence(CAR)}
    components = post().component(CAR)
    figure = plots.plot_sheet(post(), CAR, influence=influence, components=components)
    plots.save_figure(figure, path)


def components(path: Path) -> None:
    """Show the mixture's components before and after."""
    ax = plots.plot_components(post().component(CAR), prior=post().component_prior(CAR))
    plots.save_figure(ax, path)


def influence(path: Path) -> None:
    """Show how far the belief moves without each phrase."""
    words = relations_in_words(post(), CAR)
    bits = dict(zip(words, (i.bits for i in post().influence(CAR)), strict=True))
    plots.save_figure(plots.plot_influence(bits), path)


def words(path: Path) -> None:
    """Show what else could have been said of a ground."""
    check = post().predictive(CAR)[0]
    plots.save_figure(plots.plot_words(check.words, check.word), path)


def latent(path: Path) -> None:
    """Show a latent of the model's own, before and after."""
    from dataclasses import replace

    from sloop_ppl.models import Latent, preset

    which = Latent(
        "which_block",
        ("HoytBlock", "StoneBlock"),
        (0.5, 0.5),
        concerns=lambda relation: relation.ground == "HoytBlock",
        given=lambda relation, ground: replace(relation, grounds=(ground,)),
    )
    unsure = sloop.infer(TEXT, city, model=replace(preset("bayes"), latents=(which,)))
    plots.save_figure(plots.plot_latent(unsure, "which_block"), path)


def frame(path: Path) -> None:
    """Show which way one landmark faces, before and after."""
    front = post().frame(CAR)
    ax = plots.plot_frame(city, "VelvetDog", front.values, prior=front["prior"].values)
    plots.save_figure(ax, path)


def frames(path: Path) -> None:
    """Show predicted fronts of many landmarks."""
    buildings = [place.id for place in city.of_kind("building")][:12]
    network = load_weights(shipped_weights("ego-ctx"))
    fronts = dict(zip(buildings, predict_frames(network, city, buildings), strict=True))
    plots.save_figure(plots.plot_frames(city, fronts), path)


def context(path: Path) -> None:
    """Show what a network sees of a landmark."""
    plots.save_figure(plots.plot_context(context_image(city, "BallBuilding")), path)


def deviations(path: Path) -> None:
    """Show how far predictors are off (numbers drawn for this picture)."""
    rng = np.random.default_rng(0)
    boxes = {"sharp": rng.exponential(25, 80).clip(0, 180), "blunt": rng.uniform(0, 180, 80)}
    plots.save_figure(plots.plot_deviations(boxes), path)


def agreement(path: Path) -> None:
    """Show annotators' agreement beside it (numbers drawn for this picture)."""
    rng = np.random.default_rng(0)
    boxes = {"predictor": rng.exponential(30, 80).clip(0, 180)}
    people = {"Human": rng.exponential(12, 80).clip(0, 180)}
    figure = plots.draw_deviations(boxes, rng.exponential(10, 40).clip(0, 180), people)
    plots.save_figure(figure, path)


def search(path: Path) -> None:
    """Show a search over the belief that it began with."""
    first = {CAR: post().belief(CAR)}
    plots.save_figure(plots.plot_search(episode(), city, beliefs=first), path)


def film(path: Path) -> None:
    """Show a search step by step, as a GIF."""
    plots.animate_search(episode(), city, path, beliefs={CAR: post().belief(CAR)})


# Function of this file -> name in sloop_ppl.plots.
DRAWN: dict[Callable[[Path], None], str] = {
    city_map: "plot_map", blocks: "plot_blocks", belief: "plot_belief", beliefs: "plot_beliefs",
    relations: "plot_relations", change: "plot_change", sheet: "plot_sheets",
    one_sheet: "plot_sheet", components: "plot_components", influence: "plot_influence",
    words: "plot_words", latent: "plot_latent", frame: "plot_frame", frames: "plot_frames",
    context: "plot_context", deviations: "plot_deviations", agreement: "draw_deviations",
    search: "plot_search", film: "animate_search",
}  # fmt: skip

HEAD = """\
# Gallery

Every plot of `sloop_ppl.plots`, on one city, one sentence and one search. All of them are drawn by
`examples/gallery.py`; the lines under a picture are taken from it. `post()` is the posterior of

> {text}

and `episode()` a search with it. Plots of one axes take `ax=` and return it.

<div class="gallery" markdown>
{thumbnails}
</div>
"""


def file_of(draw: Callable[[Path], None]) -> str:
    """Return the name of a picture's file."""
    return f"{draw.__name__}.{'gif' if draw is film else 'png'}"


def page() -> str:
    """Return the gallery in Markdown."""
    thumbnails, parts = [], []
    for draw, name in DRAWN.items():
        file, says = file_of(draw), str(draw.__doc__).removeprefix("Show ").removesuffix(".")
        thumb = f"images/gallery/thumbs/{draw.__name__}.png"
        thumbnails.append(
            f'<figure markdown="span">[![{says}]({thumb})](#{name})'
            f"<figcaption>{name}</figcaption></figure>"
        )
        body = inspect.getsource(draw).split('"""', 2)[2]
        code = textwrap.dedent(body).strip()
        parts += [f"## {name}", says[:1].upper() + says[1:] + "."]
        parts += [f"![{says}](images/gallery/{file})", f"```python\n{code}\n```"]
    head = HEAD.format(text=TEXT, thumbnails="\n".join(thumbnails))
    return "\n\n".join([head.rstrip(), *parts]) + "\n"


def main(out: Path, names: list[str] | None = None) -> None:
    """Write pictures, thumbnails and page; with names the pictures of these alone."""
    matplotlib.use("agg")
    folder = out / "images" / "gallery"
    (folder / "thumbs").mkdir(parents=True, exist_ok=True)
    for draw in DRAWN:
        if names and draw.__name__ not in names:
            continue
        path = folder / file_of(draw)
        draw(path)
        _close()
        shrunk: Any = Image.open(path)
        shrunk.seek(getattr(shrunk, "n_frames", 1) // 2)
        shrunk = shrunk.convert("RGB")
        whole = shrunk.copy()
        shrunk.thumbnail((420, 300))
        shrunk.save(folder / "thumbs" / f"{draw.__name__}.png", optimize=True)
        if draw is not film:  # for a page, not for print
            whole.thumbnail((1000, 1000))
            whole.quantize(96).save(path, optimize=True)
    (out / "gallery.md").write_text(page(), encoding="utf-8")


def _close() -> None:
    from matplotlib import pyplot as plt

    plt.close("all")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Draw the gallery.")
    parser.add_argument("--out", type=Path, default=Path("docs"))
    parser.add_argument("names", nargs="*", help="pictures to draw; all when none")
    arguments = parser.parse_args()
    main(arguments.out, arguments.names)
