"""The main job on bundled input: read a description, infer, search, and draw it all."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from sloop_ppl.bridge._formatting import belief_lines, relation_table
from sloop_ppl.bridge._search_request import SearchRequest, SearchResult, run_request
from sloop_ppl.bridge._typed import read_places
from sloop_ppl.inference import Posterior
from sloop_ppl.outputs import check_output_folder
from sloop_ppl.plots import plot_beliefs, save_figure

__all__ = ["DEMO", "run_demo"]

DEMO = SearchRequest(
    text=(
        "The green Toyota is behind Velvet Dog, and the red bike is on West 4th Street "
        "in front of the Bolton-Pratt Building."
    ),
    map_name="cleveland",
    places=("GreenToyota=-47.5,-62.5", "RedBike=57.5,32.5"),
    start="-7.5,-7.5,45",
)
"""What the demonstration says, of which map, and where the targets truly are."""


def run_demo(folder: str | Path, show: Callable[[object], None]) -> SearchResult:
    """Run the demonstration and write its results.

    Parameters
    ----------
    folder
        Where ``belief.png``, ``search.png``, ``search.gif``, ``posterior.nc`` and ``episode.json``
        go; made if it does not exist.
    show
        Takes each line or rich table that tells what happens.

    Raises
    ------
    OutputError
        When the folder cannot be written.
    """
    out = check_output_folder(folder)
    request = replace(
        DEMO,
        out=out / "episode.json",
        figure=out / "search.png",
        animation=out / "search.gif",
    )
    show(f"“{request.text}”\n")
    result = run_request(request, notify=show, on_posterior=lambda p: _show_belief(p, out, show))
    show(f"\n{result.summary[0]}")
    show(f"wrote {', '.join(sorted(str(path) for path in out.iterdir()))}")
    return result


def _show_belief(posterior: Posterior, out: Path, show: Callable[[object], None]) -> None:
    show(relation_table(posterior.descriptions[0]))
    show("")
    for line in belief_lines(posterior):
        show(line)
    posterior.save(out / "posterior.nc")
    truths = {n: point.on(posterior.city.grid) for n, point in read_places(DEMO.places).items()}
    save_figure(plot_beliefs(posterior, truths=truths), out / "belief.png")
    show("\nstep by step:")
