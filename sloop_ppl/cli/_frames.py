"""`sloop frames`: train networks that tell which way buildings face, and let them tell."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli._options import Epochs, Json, Patience, Seed
from sloop_ppl.cli._output import print_data, print_json, progress

__all__ = ["app"]

app = typer.Typer(help="Tell which way buildings face.", no_args_is_help=True)


@app.callback()
def _frames() -> None:
    pass


@app.command("train")
def train(
    out: Annotated[
        Path, typer.Option(help="The weights to write, .safetensors.", show_default=False)
    ],
    maps: Annotated[
        Path | None,
        typer.Option(help="Folder of .osm, .osm.pbf or .geojson files.", show_default=False),
    ] = None,
    annotations: Annotated[
        list[Path] | None,
        typer.Option(help="Fronts that people drew, .jsonl, to learn from; may be repeated."),
    ] = None,
    recipe: Annotated[str, typer.Option(help="ego-ctx, ctx, ego or paper.")] = "ego-ctx",
    leave_out: Annotated[
        str, typer.Option(help="Maps of the folder not to train on, separated by commas.")
    ] = "",
    epochs: Epochs = None,
    patience: Patience = None,
    descriptions: Annotated[
        list[Path] | None,
        typer.Option(help="Description file, .jsonl, for the second stage; may be repeated."),
    ] = None,
    tuned: Annotated[
        Path | None,
        typer.Option(help="Where the second stage writes its parameters, .json, for --params."),
    ] = None,
    seed: Seed = 0,
    json: Json = False,
) -> None:
    """Train a network on buildings whose address, or whose annotators, tell how they face."""
    import numpy as np

    from sloop_ppl.errors import InputError
    from sloop_ppl.eval._frame_annotations import labels_of, read_judgements
    from sloop_ppl.eval._frame_descriptions import second_stage
    from sloop_ppl.inference._frame_examples import maps_of_folder
    from sloop_ppl.inference._frame_training import train_on_maps, training_command
    from sloop_ppl.models.frames import save_weights
    from sloop_ppl.outputs import check_output

    check_output(out, (".safetensors",))
    stage = second_stage(descriptions or (), tuned)
    if maps is None and not annotations:
        raise InputError("Missing option '--maps' or '--annotations'; give what to learn from")
    drawn, labels = labels_of(read_judgements(annotations)) if annotations else ({}, {})
    away = tuple(name for name in leave_out.split(",") if name)
    trained, _ = train_on_maps(
        {
            **({} if maps is None else maps_of_folder(maps, leave_out=away, progress=progress)),
            **drawn,
        },
        recipe,
        annotated=labels,
        epochs=epochs,
        patience=patience,
        command=training_command(recipe, leave_out, epochs, patience, seed),
        rng=np.random.default_rng(seed),
        progress=progress,
    )
    save_weights(trained, out)
    payload = {"out": str(out), **trained.about}
    if stage is not None:
        payload["tuned"] = stage(out, progress)
    print_json(payload) if json else print_data(*(f"{k}: {v}" for k, v in payload.items()))


@app.command("agreement")
def agreement(
    files: Annotated[
        list[Path], typer.Argument(help="Annotated frames, .jsonl.", show_default=False)
    ],
    json: Json = False,
) -> None:
    """Tell how far annotators agree on which way grounds face, per word and city."""
    from sloop_ppl.eval._agreement_table import agreement_lines
    from sloop_ppl.eval._frame_annotations import frame_agreement, read_judgements

    found = frame_agreement(read_judgements(files))
    print_json(found.to_json()) if json else print_data(*agreement_lines(found))


@app.command("predict")
def predict(
    map_: Annotated[
        str, typer.Argument(metavar="MAP", help="A bundled map's name or a .geojson file.")
    ],
    frames: Annotated[
        str, typer.Option(help="A name of `sloop list frames`, or a .safetensors file.")
    ] = "ego-ctx",
    landmark: Annotated[
        list[str] | None, typer.Option(help="Only this landmark; may be repeated.")
    ] = None,
    figure: Annotated[Path | None, typer.Option(help="Draw the fronts, .png .pdf .svg.")] = None,
    json: Json = False,
) -> None:
    """Tell which way the buildings of a map face, as distributions."""
    import sloop_ppl as sloop
    from sloop_ppl.inference._landmark_frames import frame_lines, frame_report, frames_of
    from sloop_ppl.plots import check_figure_path, save_figure
    from sloop_ppl.plots.frame import plot_frames

    if figure:
        check_figure_path(figure)
    city = sloop.load_map(map_)
    found = frames_of(city, frames, landmark)
    if figure:
        save_figure(plot_frames(city, found), figure)
    print_json(frame_report(city, frames, found)) if json else print_data(*frame_lines(found))
