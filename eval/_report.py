"""Write what sweeps found as Markdown and HTML, with every table and figure as files."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl.errors import InputError, OutputError
from sloop_ppl.eval._examples import EXAMPLES
from sloop_ppl.eval._inventory import map_finder
from sloop_ppl.eval._paper_tables import frame_table, table_one, table_two
from sloop_ppl.eval._quality_report import quality_section
from sloop_ppl.eval._question_summary import question_table
from sloop_ppl.eval._report_figures import completed_figure, reward_figure
from sloop_ppl.eval._reward_tables import (
    comparison_table,
    completed_table,
    overview_table,
    reward_table,
    sweeps_table,
)
from sloop_ppl.eval._summary import in_short
from sloop_ppl.eval._tables import Estimate, Table, literal
from sloop_ppl.eval.results import Results
from sloop_ppl.outputs import check_output, check_output_folder, written_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Report", "make_report", "write_docs", "write_report"]


@dataclass(frozen=True)
class Picture:
    """A figure that is drawn when it is written."""

    name: str
    caption: str
    draw: Callable[[], Figure]


@dataclass(frozen=True)
class Report:
    """A report: headings, paragraphs, tables and pictures in the order in which they are read."""

    title: str
    parts: tuple[str | Table | Picture, ...]

    def markdown(self, pictures: str) -> str:
        """Return it as Markdown, the pictures in a folder beside it."""
        blocks = [f"# {literal(self.title)}"]
        for part in self.parts:
            if isinstance(part, Table):
                blocks.append(f"**{literal(part.title)}**\n\n{part.markdown()}")
            elif isinstance(part, Picture):
                caption = literal(part.caption)
                blocks.append(f"![{part.name}]({pictures}/{part.name}.png)\n\n*{caption}*")
            else:
                blocks.append(part)
        return "\n\n".join(blocks) + "\n"


def make_report(
    sweeps: Sequence[Results],
    *,
    quality: str | Path | None = None,
    maps: str | Path | None = None,
) -> Report:
    """Return the report of a sweep, set beside other sweeps of the same descriptions.

    Parameters
    ----------
    sweeps
        At least one; the first is the one that is told in full.
    quality
        What ``sloop eval quality --json`` printed, in a file, to be told as well.
    maps
        Folder of map files, for the pictures; None for the bundled maps.

    Raises
    ------
    InputError
        When the sweeps are of different descriptions, or a file cannot be read.
    """
    main = sweeps[0]
    payload = None if quality is None else _quality_payload(quality)
    parts: list[str | Table | Picture] = ["## In short", in_short(main, payload)]
    if payload is not None:
        parts += [
            "## Beliefs, without any search",
            *(
                Picture(*part) if isinstance(part, tuple) else part
                for part in quality_section(payload)
            ),
        ]
    parts += [
        "## Search",
        overview_table(main),
        Picture(
            "completed",
            "Searches that had found their target after so many steps",
            lambda: completed_figure(main),
        ),
        Picture(
            "rewards",
            "Discounted reward of all trials: quartiles, median (line) and mean (diamond)",
            lambda: reward_figure(main),
        ),
    ]
    if "asking" in main.manifest:
        parts += ["### Questions", question_table(main)]
    if len(main.models) > 1:
        parts += ["### Comparisons", comparison_table(main)]
    parts += [
        "### The paper's tables",
        table_one(main),
        table_two(main),
        frame_table(main),
        "### Completed searches",
        completed_table(main),
        reward_table(main),
    ]
    if len(sweeps) > 1:
        parts += ["### Beliefs and planners", sweeps_table(sweeps)]
    parts += [*_examples(main, maps), "## Data and settings", _data_and_settings(sweeps)]
    return Report("Results", tuple(parts))


def write_report(report: Report, folder: str | Path) -> Path:
    """Write ``report.md``, ``report.html`` and the folders ``tables`` and ``figures``.

    Parameters
    ----------
    folder
        Where to write it; made if need be.

    Returns
    -------
    Path
        That of the Markdown file.

    Raises
    ------
    OutputError
        When something cannot be written.
    """
    home = check_output_folder(folder)
    tables = check_output_folder(home / "tables")
    for part in report.parts:
        if isinstance(part, Table):
            _write(tables / f"{part.name}.csv", part.csv())
            _write(tables / f"{part.name}.tex", part.latex())
    _draw(report, check_output_folder(home / "figures"))
    text = report.markdown("figures")
    _write(home / "report.html", _page(report.title, text))
    _write(home / "report.md", text)
    return home / "report.md"


def write_docs(report: Report, path: str | Path) -> None:
    """Write the report as one Markdown file, its pictures in ``images/NAME`` beside it.

    Raises
    ------
    OutputError
        When something cannot be written, or the path does not end in ``.md``.
    """
    file = check_output(path, (".md",))
    pictures = f"images/{file.stem}"
    _draw(report, check_output_folder(file.parent / pictures))
    _write(file, report.markdown(pictures))


def _data_and_settings(sweeps: Sequence[Results]) -> str:
    """Return what the first sweep was made of, and the names of the others."""
    manifest = sweeps[0].manifest
    files = ", ".join(
        f"`{name}` ({digest[:12]})" for name, digest in manifest["descriptions"].items()
    )
    maps = ", ".join(f"{name} ({digest[:12]})" for name, digest in manifest["maps"].items())
    first, second = manifest["primary"]["models"]
    named = (
        f"- primary comparison, named before the run: discounted reward of {first} minus that of "
        f"{second}, range {manifest['primary']['range_cells']:g}"
    )
    lines = [
        f"- {manifest['n_descriptions']} descriptions of {manifest['n_targets']} targets: {files}",
        f"- {len(manifest['maps'])} maps: {maps}",
        f"- models: {', '.join(manifest['model_names'])}",
        (
            f"- ranges of the sensor: {', '.join(f'{r:g}' for r in manifest['ranges_cells'])} "
            f"cells; seed {manifest['searching']['seed']}; {manifest['n_trials']} trials"
        ),
        f"- {sweeps[0].label}",
        *(f"- compared with it: {sweep.label}" for sweep in sweeps[1:]),
        *([named] if first != second else []),
        f"- sloop_ppl {manifest['version']}, commit {manifest['git'] or 'unknown'}; "
        + ", ".join(f"{name} {version}" for name, version in manifest["packages"].items()),
    ]
    return "\n".join(f"- {literal(line[2:])}" for line in lines)


def _examples(main: Results, maps: str | Path | None) -> list[str | Table | Picture]:
    """Return the pictures of the example trials, where their episodes are at hand."""
    from sloop_ppl.planning import read_episode

    model, _, range_cells = main.primary
    find = map_finder(maps)
    pictures: list[str | Table | Picture] = []
    for example in EXAMPLES:
        path = main.folder.examples / f"{example}.json"
        if not path.is_file():
            continue
        try:
            episode = read_episode(path)
        except InputError as error:
            raise InputError(f"Example '{path}' cannot be read: {error}") from error
        name = next(iter(episode.places))
        facts = main.facts.get((parse_json(read_text(path, "Example")).get("description"), name))
        if facts is None:
            raise InputError(
                f"'{path}' is an episode of no target of this sweep; delete it, and give the same "
                "`sloop eval search` command again"
            )
        city = find(facts.map)
        pictures.append(
            Picture(
                f"example-{example}",
                f"The {example} trial of {model}, range {range_cells:g}: {name} of "
                f"{facts.description} ({facts.map}), discounted reward "
                f"{Estimate(episode.discounted_return).text()}",
                lambda episode=episode, city=city: _search_figure(episode, city),  # type: ignore[misc]
            )
        )
    return ["### Example trials", *pictures] if pictures else []


def _search_figure(episode: Any, city: Any) -> Figure:
    from matplotlib.figure import Figure

    from sloop_ppl.plots import plot_search

    figure = Figure(figsize=(6.6, 6.9), layout="constrained")
    plot_search(episode, city, ax=figure.subplots(), beliefs=dict(episode.beliefs[0]))
    return figure


def _quality_payload(path: str | Path) -> Mapping[str, Any]:
    text = read_text(path, "Scores")
    try:
        payload = parse_json(text, finite=False)
    except ForeignFault as error:
        raise InputError(f"'{path}' is not JSON: {error}") from error
    if not isinstance(payload, dict) or "models" not in payload or "paired" not in payload:
        raise InputError(
            f"'{path}' is not what `sloop eval quality --json` prints; expected 'models' and "
            "'paired' in it"
        )
    return payload


def _draw(report: Report, folder: Path) -> None:
    from sloop_ppl.plots import save_figure

    for part in report.parts:
        if isinstance(part, Picture):
            save_figure(part.draw(), folder / f"{part.name}.png", dpi=140)


def _page(title: str, text: str) -> str:
    from markdown_it import MarkdownIt

    # Ids and names are in the text: whatever they hold, no HTML of theirs is passed on.
    body = MarkdownIt("commonmark", {"html": False}).enable("table").render(text)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{html.escape(title)}</title>\n<style>{_STYLE}</style></head>\n<body>\n{body}</body></html>\n"
    )


_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #22252b; max-width: 76em; margin: 2em auto;
       padding: 0 1.5em; }
table { border-collapse: collapse; margin: 1em 0 0.3em; font-size: 13px; }
th { border-bottom: 1.5px solid #22252b; border-top: 1.5px solid #22252b; vertical-align: bottom; }
th, td { padding: 0.25em 0.8em; white-space: nowrap; }
th { white-space: normal; }
tr:last-child td { border-bottom: 1.5px solid #22252b; }
img { max-width: 100%; }
h2 { margin-top: 2.2em; border-bottom: 1px solid #c9ccd1; }
"""


def _write(path: Path, text: str) -> None:
    try:
        with written_whole(path) as whole:
            whole.write_text(text, encoding="utf-8")
    except OSError as error:
        raise OutputError(f"'{path}' cannot be written: {error.strerror}") from error
