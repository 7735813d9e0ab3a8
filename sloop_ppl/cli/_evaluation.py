"""`sloop eval`: how well texts are read, and what beliefs and searches are worth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli._options import (
    Epochs,
    Files,
    Fov,
    Json,
    Maps,
    Nlp,
    Params,
    Patience,
    Seed,
    Sims,
    unused_options,
)
from sloop_ppl.cli._output import print_data, print_json, progress

__all__ = ["app"]

Gold = Annotated[
    bool, typer.Option("--gold/--parsed", help="Gold relations, or those the parser reads.")
]
Models = Annotated[
    str | None, typer.Option(help="Models, separated by commas; else all.", show_default=False)
]
Cv = Annotated[
    str | None,
    typer.Option(help="city: refit parameters without the line's city.", show_default=False),
]
Fits = Annotated[
    Path | None,
    typer.Option(
        help="File in which what --cv refits is kept for the next command.", show_default=False
    ),
]

Annotations = Annotated[
    list[Path] | None,
    typer.Option(
        help="Gold of lines that have none, .jsonl of id and relations; may be repeated.",
        show_default=False,
    ),
]

LearnFrom = Annotated[
    list[Path] | None,
    typer.Option(
        help="Further description files that --cv learns from; may be repeated.",
        show_default=False,
    ),
]

Workers = Annotated[
    int | None, typer.Option(help="Processes; else one per processor.", show_default=False)
]

app = typer.Typer(help="Score parsers, beliefs and searches on descriptions.", no_args_is_help=True)


@app.command()
def parse(
    files: Files,
    maps: Maps = None,
    parser: Annotated[
        str, typer.Option(help="rules, dependency_paths, or module:name of a parser of yours.")
    ] = "rules",
    nlp: Nlp = None,
    merge_maps: Annotated[
        bool, typer.Option("--merge-maps", help="Read on the landmarks of all maps at once.")
    ] = False,
    misspell: Annotated[
        float, typer.Option(help="Share of the words of five letters or more to misspell.")
    ] = 0.0,
    annotations: Annotated[
        Path | None,
        typer.Option(help="Gold relations by id, for lines without.", show_default=False),
    ] = None,
    misses: Annotated[
        bool, typer.Option("--misses", help="Print each line that is not wholly read right.")
    ] = False,
    confidence: Annotated[
        bool, typer.Option("--confidence", help="Judge the confidence of what was read.")
    ] = False,
    seed: Annotated[int, typer.Option(help="Seed of the misspelling and of intervals.")] = 0,
    json: Json = False,
) -> None:
    """Read descriptions and compare with their gold relations."""
    from sloop_ppl.eval._parse_files import parse_score_lines, score_files

    score = score_files(
        files, maps=maps, parser=parser, nlp=nlp, merged=merge_maps, misspelt=misspell,
        annotations=annotations, confidence=confidence, seed=seed,
    )  # fmt: skip
    if json:
        print_json(score.to_json())
    else:
        print_data(*parse_score_lines(score, misses=misses))


@app.command()
def describe(
    files: Files,
    maps: Maps = None,
    json: Json = False,
) -> None:
    """Say what is in a set: parse yield, relations, targets and descriptions."""
    from sloop_ppl.eval._table_lines import table_lines
    from sloop_ppl.eval.describe import describe_files, summary_tables

    summary = describe_files(files, maps=maps)
    if json:
        print_json(summary.to_json())
    else:
        print_data(*(line for table in summary_tables(summary) for line in table_lines(table)))


@app.command()
def quality(
    files: Files,
    maps: Maps = None,
    annotations: Annotations = None,
    gold: Gold = True,
    models: Models = None,
    params: Params = None,
    cv: Cv = None,
    fits: Fits = None,
    learn_from: LearnFrom = None,
    figure: Annotated[
        Path | None, typer.Option(help="Draw scores and coverage: .png, .pdf, .svg or .jpg.")
    ] = None,
    metric: Annotated[
        list[str] | None,
        typer.Option(
            help="A metric of your own, FILE.py:NAME, beside the others; may be repeated.",
            show_default=False,
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Score what models believe against where the targets are."""
    from sloop_ppl.eval._quality_files import draw_quality, quality_lines, score_quality
    from sloop_ppl.plots import check_figure_path

    if figure:
        check_figure_path(figure)
    found = score_quality(
        files,
        maps=maps,
        gold=gold,
        models=models,
        params=params,
        cv=cv,
        fits=fits,
        progress=progress,
        metrics=tuple(metric or ()),
        annotations=annotations,
        learn_from=tuple(learn_from or ()),
    )
    if figure:
        draw_quality(found, figure)
    if json:
        print_json(found.to_json())
    else:
        print_data(*quality_lines(found))


@app.command()
def search(
    context: typer.Context,
    files: Files,
    out: Annotated[Path, typer.Option(help="Folder of the run; a stopped run goes on there.")],
    maps: Maps = None,
    gold: Gold = True,
    models: Models = None,
    ranges: Annotated[str, typer.Option(help="Ranges of the sensor, cells.")] = "3,4,5",
    starts: Annotated[int, typer.Option(help="Starts per target.")] = 1,
    planner: Annotated[str, typer.Option(help="Planner; see `sloop list planners`.")] = "fast",
    sims: Sims = 1000,
    rollout: Annotated[
        str | None,
        typer.Option(help="published, random or informed; else the planner's.", show_default=False),
    ] = None,
    fov: Fov = 90,
    steps: Annotated[
        int | None,
        typer.Option(
            help="Steps after which a search ends; else 200, more on a larger map.",
            show_default=False,
        ),
    ] = None,
    params: Params = None,
    cv: Cv = None,
    fits: Fits = None,
    annotations: Annotations = None,
    learn_from: LearnFrom = None,
    primary: Annotated[
        str | None,
        typer.Option(help="The two models compared first; else bayes,sloop-m4."),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of all random numbers.")] = 0,
    workers: Workers = None,
    backend: Annotated[str, typer.Option(help="joblib, ray or dask.")] = "joblib",
    address: Annotated[
        str | None, typer.Option(help="Of the Ray or Dask cluster.", show_default=False)
    ] = None,
    skip_bad: Annotated[
        bool, typer.Option("--skip-bad", help="Pass over lines that have a fault.")
    ] = False,
    questions: Annotated[
        str | None,
        typer.Option(
            help="How many questions may be asked, such as 0,1,2; else none.", show_default=False
        ),
    ] = None,
    question_cost: Annotated[
        str, typer.Option(help="What a question costs, such as 10,30.")
    ] = "10",
    question_steps: Annotated[int, typer.Option(help="How many steps a question takes.")] = 0,
    answerer: Annotated[
        str,
        typer.Option(
            help="a: oracle geometry; b: another one, lasting errors; c: what was recorded."
        ),
    ] = "a",
    answer_error: Annotated[
        float | None,
        typer.Option(help="How often answers are wrong; 0.1 of a, 0 of b.", show_default=False),
    ] = None,
    believed_error: Annotated[
        float | None,
        typer.Option(
            help="How often they are taken to be; else as --answer-error says, or 0.1.",
            show_default=False,
        ),
    ] = None,
    guess: Annotated[float, typer.Option(help="Share of the answers that are guessed.")] = 0.0,
    believed_guess: Annotated[
        float | None,
        typer.Option(help="Share taken to be guessed; else as it is.", show_default=False),
    ] = None,
    rho: Annotated[
        float, typer.Option(help="How often answerer b shares the speaker's mistake.")
    ] = 0.5,
    asking: Annotated[
        str, typer.Option(help="planned, random, or fixed: the side of the first ground.")
    ] = "planned",
) -> None:
    """Search for every described target under every model and range; resumable."""
    from sloop_ppl.cli._sweep_progress import sweep_progress
    from sloop_ppl.eval._answerers import AskingSettings
    from sloop_ppl.eval._sweep_files import SweepRequest, sweep_files
    from sloop_ppl.eval.trials import Searching

    searching = Searching(planner, sims, rollout, fov, steps, seed)
    asked = AskingSettings(
        answerer, answer_error, believed_error, guess, believed_guess, rho, asking, question_steps
    )
    with sweep_progress() as shown:
        folder = sweep_files(
            SweepRequest(
                files, out, maps, gold, models, params, cv, fits, tuple(annotations or ()),
                tuple(learn_from or ()), ranges, starts, searching, primary, skip_bad, workers,
                backend, address, questions, question_cost, asked,
            ),
            notify=progress,
            progress=shown,
        )  # fmt: skip
    for line in unused_options(context, planner):
        progress(line)
    print_data(f"{folder.manifest['n_trials']} trials in {out}; see `sloop eval report {out}`")


@app.command()
def report(
    folders: Annotated[
        list[Path],
        typer.Argument(help="Folder of a run; others are set beside it.", show_default=False),
    ],
    out: Annotated[
        Path | None,
        typer.Option(help="Folder of the report; else `report` in the run's.", show_default=False),
    ] = None,
    quality: Annotated[
        Path | None, typer.Option(help="What `sloop eval quality --json` printed, to tell too.")
    ] = None,
    docs: Annotated[
        Path | None, typer.Option(help="Write one .md file instead, pictures beside it.")
    ] = None,
    maps: Maps = None,
    json: Json = False,
) -> None:
    """Report what a run found: tables and figures as Markdown, HTML, LaTeX and CSV."""
    from sloop_ppl.eval._question_summary import report_summary
    from sloop_ppl.eval._report import make_report, write_docs, write_report
    from sloop_ppl.eval.results import read_results

    sweeps = [read_results(folder) for folder in folders]
    if json:
        print_json(report_summary(sweeps[0]))
        return
    made = make_report(sweeps, quality=quality, maps=maps)
    if docs:
        write_docs(made, docs)
    print_data(str(docs or write_report(made, out or folders[0] / "report")))


@app.command()
def frames(
    maps: Annotated[
        Path | None,
        typer.Option(help="Folder of .osm, .osm.pbf or .geojson files; else the bundled maps."),
    ] = None,
    recipes: Annotated[
        str, typer.Option(help="Recipes to train, separated by commas; `paper` is one too.")
    ] = "ego-ctx,ctx,ego",
    descriptions: Annotated[
        list[Path] | None,
        typer.Option(help="Description file, .jsonl, to score fronts on too; may be repeated."),
    ] = None,
    annotations: Annotated[
        list[Path] | None,
        typer.Option(
            help="Annotated fronts, .jsonl, to score predictors and people against; may be "
            "repeated."
        ),
    ] = None,
    epochs: Epochs = None,
    patience: Patience = None,
    seed: Seed = 0,
    figure: Annotated[
        Path | None, typer.Option(help="Draw the deviations, .png .pdf .svg.")
    ] = None,
    json: Json = False,
) -> None:
    """Hold cities out in turn and score which way their buildings are said to face."""
    from sloop_ppl.eval._frame_files import frame_lines, score_frames
    from sloop_ppl.plots import check_figure_path, save_figure

    if figure:
        check_figure_path(figure)
    found = score_frames(
        maps, recipes=recipes, descriptions=descriptions or (), annotations=annotations or (),
        epochs=epochs, patience=patience, seed=seed, progress=progress,
    )  # fmt: skip
    if figure:
        save_figure(found.figure(), figure)
    print_json(found.to_json()) if json else print_data(*frame_lines(found))


@app.command()
def fit(
    files: Files,
    out: Annotated[Path, typer.Option(help="The numbers to write, .json; --params reads them.")],
    models: Annotated[
        str | None,
        typer.Option(
            help="Candidates of `sloop list candidates`, models, or FILE.py:NAME, separated by "
            "commas; else the likelihood families.",
            show_default=False,
        ),
    ] = None,
    maps: Maps = None,
    annotations: Annotations = None,
    json: Json = False,
) -> None:
    """Fit models with each map left out, choose inside the folds, and fit the best to all.

    Where each line of a file has a map of its own, the file's maps are left out together.

    Ctrl-C keeps the finished fits; the same command goes on from there.
    """
    from sloop_ppl.eval._fit_files import fit_files, fit_tables
    from sloop_ppl.eval._table_lines import table_lines

    selection, fitted = fit_files(
        files, out=out, models=models, maps=maps, annotations=annotations, progress=progress
    )
    if json:
        print_json(fitted.to_json())
    else:
        tables = fit_tables(selection, fitted)
        print_data(*(line for table in tables for line in table_lines(table)))


@app.command()
def camera(
    maps: Annotated[
        str | None,
        typer.Option(help="Names or paths of maps, separated by commas; else the bundled maps."),
    ] = None,
    altitudes: Annotated[str, typer.Option(help="How high the drone hangs, metres.")] = "14,10",
    detectors: Annotated[
        str, typer.Option(help="Detectors, separated by commas.")
    ] = "camera,segmentation,rays",
    poses: Annotated[int, typer.Option(min=1, help="Poses of each map and altitude.")] = 60,
    figure: Annotated[
        Path | None, typer.Option(help="Draw rates and errors, .png .pdf .svg.")
    ] = None,
    seed: Seed = 0,
    json: Json = False,
) -> None:
    """Measure how often the drone's detectors err, over poses around targets in the simulator."""
    from sloop_ppl.eval._camera_sweep import sweep_camera, sweep_figure, sweep_lines
    from sloop_ppl.maps import bundled_maps, load_map
    from sloop_ppl.plots import check_figure_path, save_figure
    from sloop_ppl.simulation import need_simulator, read_altitudes

    need_simulator()
    if figure:
        check_figure_path(figure)
    names = [n for n in (maps or "").split(",") if n] or bundled_maps()
    scores = sweep_camera(
        [load_map(n) for n in names], altitudes_m=read_altitudes(altitudes),
        detectors=tuple(d for d in detectors.split(",") if d), poses=poses, seed=seed,
        notify=progress,
    )  # fmt: skip
    if figure:
        save_figure(sweep_figure(scores), figure)
    if json:
        print_json({"poses": poses, "seed": seed, "scores": [s.to_json() for s in scores]})
    else:
        print_data(*sweep_lines(scores))


@app.command()
def fly(
    out: Annotated[Path, typer.Option(help="Folder of the run; a stopped run goes on there.")],
    files: Annotated[
        list[Path] | None,
        typer.Argument(help="Description files, .jsonl; else the bundled.", show_default=False),
    ] = None,
    maps: Maps = None,
    targets: Annotated[int, typer.Option(min=1, help="Described targets, at most.")] = 40,
    seeds: Annotated[int, typer.Option(min=1, help="Trials of each.")] = 2,
    sims: Sims = 500,
    steps: Annotated[int, typer.Option(min=1, help="Steps of a search, at most.")] = 120,
    workers: Workers = None,
    json: Json = False,
) -> None:
    """Search for the same targets on the grid, with rays, and with the camera in the simulator."""
    from sloop_ppl.eval._flown import fly_trials
    from sloop_ppl.eval._flown_report import flown_lines, flown_summary
    from sloop_ppl.eval._inventory import map_finder
    from sloop_ppl.eval.descriptions import bundled_examples, read_descriptions
    from sloop_ppl.simulation import need_simulator

    need_simulator()
    find_map = map_finder(maps)
    described = read_descriptions(files, find_map) if files else bundled_examples()
    trials = fly_trials(
        described, find_map, out, targets=targets, seeds=seeds, sims=sims, max_steps=steps,
        workers=workers, notify=progress,
    )  # fmt: skip
    summary = flown_summary(trials)
    if json:
        print_json({"arms": [s.to_json() for s in summary]})
    else:
        print_data(*flown_lines(summary))
