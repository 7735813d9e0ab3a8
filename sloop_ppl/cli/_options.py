"""The options that several commands share, and which options were typed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

__all__ = [
    "Area",
    "Engine",
    "Epochs",
    "Files",
    "Fov",
    "Frames",
    "Hearer",
    "Json",
    "Map",
    "Maps",
    "Model",
    "Nlp",
    "Params",
    "Patience",
    "Prior",
    "Seed",
    "Sims",
    "Targets",
    "Text",
    "Variant",
    "Viewpoint",
    "as_typed",
    "given",
    "unused_options",
]

Text = Annotated[str, typer.Argument(help="What was said, in English.", show_default=False)]
Map = Annotated[
    str, typer.Option("--map", help="A bundled map's name or a .geojson file.", show_default=False)
]
Files = Annotated[list[Path], typer.Argument(help="Description files, .jsonl.", show_default=False)]
Maps = Annotated[Path | None, typer.Option(help="Folder of map files; else the bundled maps.")]
Targets = Annotated[
    Path | None,
    typer.Option(help="JSON list of {id, names, colour, kind}: the objects searched for."),
]
Nlp = Annotated[
    str | None,
    typer.Option(
        help="Read along dependency paths with this spaCy pipeline (name or folder).",
        show_default=False,
    ),
]
Model = Annotated[
    str, typer.Option(help="Observation model: a name of `sloop list models`, or FILE.py:NAME.")
]
Variant = Annotated[
    str, typer.Option(help="Which source a sloop model follows: published (code) or paper (text).")
]
Engine = Annotated[str, typer.Option(help="Inference engine; see `sloop list engines`.")]
Frames = Annotated[
    str | None, typer.Option(help="Frame predictor; see `sloop list frames`.", show_default=False)
]
Params = Annotated[
    Path | None,
    typer.Option(help="TOML or JSON file of the model's parameters.", show_default=False),
]
Prior = Annotated[
    str | None,
    typer.Option(
        help="Belief before anything is said: a name of `sloop list priors`, a .nc or .json file.",
        show_default=False,
    ),
]
Viewpoint = Annotated[
    str,
    typer.Option(
        help="Where who speaks looks from: a map, whose up is north, or the ground, where up, "
        "down, above and under are no compass words."
    ),
]
Fov = Annotated[float, typer.Option(help="Opening of the sensor's fan, degrees.")]
Sims = Annotated[int, typer.Option(help="Simulations per step.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of all that is drawn.")]
Epochs = Annotated[
    int | None, typer.Option(min=1, help="At most so many passes.", show_default="recipe's")
]
Patience = Annotated[
    int | None,
    typer.Option(min=1, help="Stop after so many without gain.", show_default="recipe's"),
]
Hearer = Annotated[
    str | None,
    typer.Option(
        help='Where who listens is ("north of you"), x,y in metres or @lat,lon in degrees; may be '
        "outside the map.",
        show_default=False,
    ),
]
Area = Annotated[
    str | None,
    typer.Option(
        help="Where the targets are searched for: W,S,E,N in metres, @W,S,E,N in degrees, or a "
        ".geojson file of a polygon; else the whole map.",
        show_default=False,
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON on stdout.")]


def given(context: typer.Context) -> list[str]:
    """Return the names of the parameters that were typed."""
    return [n for n in context.params if str(context.get_parameter_source(n)).endswith("LINE")]


def as_typed(name: str) -> str:
    """Return how a parameter is typed."""
    return "TEXT" if name == "text" else f"--{name.strip('_').replace('_', '-')}"


def unused_options(context: typer.Context, planner: str) -> list[str]:
    """Return a line for each option that was typed although the planner does not use it."""
    from sloop_ppl.planning.planners import NOT_SIMULATING

    if planner not in NOT_SIMULATING:
        return []
    return [
        f"note: planner '{planner}' runs no simulations, so {as_typed(name)} is not used"
        for name in given(context)
        if name in ("sims", "rollout")
    ]
