"""Draw a saved episode again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sloop_ppl._foreign import parse_json, read_text
from sloop_ppl.bridge._formatting import outcome_line
from sloop_ppl.errors import InputError, SloopError
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.planning import Episode, read_episode
from sloop_ppl.plots import animate_search, check_figure_path, plot_search, save_figure

__all__ = ["draw_episode", "replay_report"]


def replay_report(
    path: Path,
    map_name: str | None = None,
    *,
    figure: Path | None = None,
    animation: Path | None = None,
) -> tuple[dict[str, Any], str]:
    """Draw the episode of a file; return it as ``sloop search --json`` and as one line.

    Parameters
    ----------
    path
        An episode that ``sloop search --out`` saved.
    map_name
        Its map; the bundled one that the episode names when None.
    figure, animation
        Where the drawings go, as far as they are wanted.

    Raises
    ------
    InputError
        When the file holds no episode of this version, or one of another map.
    """
    if figure:
        check_figure_path(figure)
    if animation:
        check_figure_path(animation, animation=True)
    episode = read_episode(path)
    city = _map_of(episode, map_name)
    draw_episode(episode, city, figure, animation)
    saved = parse_json(read_text(path, "Episode"))
    named = {key: saved[key] for key in ("map", "model", "planner", "seed", "said") if key in saved}
    return {**named, **episode.to_json()}, outcome_line(episode)


def draw_episode(
    episode: Episode, city: CityMap, figure: Path | None, animation: Path | None
) -> None:
    """Write a figure of an episode, an animation, or both."""
    imagined = episode.imagined
    if figure:
        save_figure(plot_search(episode, city, imagined=imagined), figure)
    if animation:
        beliefs = episode.beliefs or None
        animate_search(episode, city, animation, beliefs=beliefs, imagined=imagined)


def _map_of(episode: Episode, map_name: str | None) -> CityMap:
    if map_name is None:
        try:
            city = load_map(episode.map_name)
        except SloopError:
            raise InputError(
                f"The episode was searched on map '{episode.map_name}', which is not a bundled "
                "one; give its file with --map"
            ) from None
    else:
        city = load_map(map_name)
    shape = episode.views.shape[1:]
    if city.name != episode.map_name or city.grid.shape != shape:
        raise InputError(
            f"The episode was searched on another map ('{episode.map_name}', {shape} cells); "
            f"found '{city.name}', {city.grid.shape} cells; give the map it was searched on"
        )
    if episode.map_digest and city.digest != episode.map_digest:
        raise InputError(
            f"The episode was searched on another version of map '{city.name}': its content has "
            "changed since; give the file it was searched on with --map, or search again"
        )
    return city
