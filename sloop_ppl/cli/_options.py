"""The options that several commands share, and which options were typed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.errors import InputError

__all__ = [
    "Animation",
    "AnswerError",
    "Answers",
    "Area",
    "Engine",
    "EpisodeOut",
    "Epochs",
    "Explain",
    "Figure",
    "Files",
    "FindEach",
    "Fov",
    "Frames",
    "Hearer",
    "Json",
    "Map",
    "Maps",
    "MaybeMap",
    "MaybeText",
    "Model",
    "Nlp",
    "Params",
    "Patience",
    "Planner",
    "PosteriorOut",
    "Prior",
    "QuestionCost",
    "QuestionSteps",
    "Questions",
    "Range",
    "Rollout",
    "Say",
    "Seed",
    "Settings",
    "Sims",
    "Start",
    "Steps",
    "Targets",
    "Text",
    "TruePlaces",
    "Variant",
    "Viewpoint",
    "as_typed",
    "given",
    "refuse_options",
    "refuse_options_of_answers",
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
MaybeText = Annotated[
    str | None, typer.Argument(help="What was said, in English.", show_default=False)
]
MaybeMap = Annotated[
    str | None,
    typer.Option("--map", help="A bundled map's name or a .geojson file.", show_default=False),
]
TruePlaces = Annotated[
    list[str] | None,
    typer.Option(
        help="Where a target truly is, OBJECT=x,y in metres or OBJECT=@lat,lon in degrees; "
        "else it is imagined."
    ),
]
Start = Annotated[
    str | None,
    typer.Option(help="Where the search starts, x,y[,heading] or @lat,lon[,heading]; else drawn."),
]
Say = Annotated[
    list[str] | None,
    typer.Option(
        "--say", help="STEP=TEXT: what is said once so many steps are taken; may be repeated."
    ),
]
Planner = Annotated[str, typer.Option(help="Planner, see `sloop list planners`; or FILE.py:NAME.")]
Range = Annotated[float, typer.Option("--range", help="How far the sensor sees, cells.")]
Steps = Annotated[
    int | None,
    typer.Option(
        help="Steps after which the search ends; else 200, more on a larger map.",
        show_default=False,
    ),
]
Rollout = Annotated[
    str | None,
    typer.Option(
        help="Rollouts: published, random, or informed (fast alone); else the planner's own.",
        show_default=False,
    ),
]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", help="NAME=VALUE of any other setting, such as no_fly=true."),
]
FindEach = Annotated[
    bool, typer.Option("--find-each", help="One find action per target, as in the paper.")
]
Answers = Annotated[
    str | None,
    typer.Option(
        help="Who answers questions: human, simulated, or a file of answers; else none.",
        show_default=False,
    ),
]
Questions = Annotated[int, typer.Option(help="How many questions may be asked.")]
QuestionCost = Annotated[float, typer.Option(help="What a question takes from the reward.")]
QuestionSteps = Annotated[int, typer.Option(help="How many steps a question takes.")]
AnswerError = Annotated[float, typer.Option(help="How often answers are wrong, or taken to be.")]
Explain = Annotated[bool, typer.Option("--explain", help="Say before each step why it is taken.")]
EpisodeOut = Annotated[Path | None, typer.Option(help="Save the episode, .json.")]
PosteriorOut = Annotated[
    Path | None, typer.Option(help="Save what is believed after the search, .nc.")
]
Figure = Annotated[Path | None, typer.Option(help="Draw the search, .png .pdf .svg.")]
PlayedPage = Annotated[
    Path | None, typer.Option(help="Write a page that plays it without a server, .html.")
]
Animation = Annotated[Path | None, typer.Option(help="Film the search, .gif or .mp4.")]
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


def refuse_options(names: Iterable[str], option: str, reason: str) -> None:
    """Refuse the first of the options that do not go with another one."""
    for name in names:
        raise InputError(f"{as_typed(name)} does not go with {option}; leave it out: {reason}")


_OF_ANSWERS = ("questions", "question_cost", "question_steps", "answer_error")


def refuse_options_of_answers(context: typer.Context, answers: str | None) -> None:
    """Refuse what only answers use where nobody answers."""
    if answers is None:
        names = (n for n in given(context) if n in _OF_ANSWERS)
        refuse_options(names, "a search without --answers", "nobody answers")
