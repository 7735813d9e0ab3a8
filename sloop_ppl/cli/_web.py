"""`sloop serve` and `sloop collect`."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli._options import Json, Seed
from sloop_ppl.cli._output import print_data, print_json, progress
from sloop_ppl.errors import InputError

__all__ = ["collect_app", "serve"]

collect_app = typer.Typer(help="Collect descriptions of objects on maps.", no_args_is_help=True)

Answers = Annotated[
    Path, typer.Argument(help="What the collection page saved, .jsonl.", show_default=False)
]


def serve(
    map_: Annotated[
        list[str] | None,
        typer.Option(
            "--map",
            help="A bundled map's name or a .geojson file; may be repeated.",
            show_default=False,
        ),
    ] = None,
    host: Annotated[
        str, typer.Option(help="Where to listen; another than this machine lets others in.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port; 0 for any free one.")] = 8765,
    open_: Annotated[bool, typer.Option("--open", help="Open it in the browser.")] = False,
    folder: Annotated[
        Path, typer.Option(help="Where annotations and descriptions are kept.")
    ] = Path("sloop-web"),
    queue: Annotated[
        Path | None,
        typer.Option(help="Description file whose phrases are annotated; else those of the map."),
    ] = None,
    study: Annotated[
        Path | None, typer.Option(help="What `sloop collect prepare` wrote; else one is drawn.")
    ] = None,
) -> None:
    """Serve the workbench and the pages for annotators and speakers, until Ctrl-C."""
    _need_web()
    from sloop_ppl.web import Study, WebSettings, serve

    settings = WebSettings(
        maps=tuple(map_ or ()), host=host, folder=folder, queue=queue,
        study=None if study is None else Study.load(study),
    )  # fmt: skip

    def notify(address: str) -> None:
        guest = address.replace("/?", "/collect?").replace(settings.token, settings.guest_token)
        print_data(f"Workbench: {address}", f"For people who describe maps: {guest}")
        progress("Ctrl-C ends it")

    serve(settings, port, open_browser=open_, notify=notify)


@collect_app.callback()
def _collect() -> None:
    pass


@collect_app.command("prepare")
def prepare(
    out: Annotated[Path, typer.Option(help="The study to write, .json.", show_default=False)],
    maps: Annotated[
        str | None,
        typer.Option(help="Names or paths of maps, separated by commas; else the bundled maps."),
    ] = None,
    per_map: Annotated[int, typer.Option(min=1, help="Configurations of each map.")] = 10,
    people: Annotated[int, typer.Option(min=1, help="People who describe each at most.")] = 5,
    seed: Seed = 0,
    json: Json = False,
) -> None:
    """Draw configurations of two objects on maps, for `sloop serve --study`."""
    _need_web()
    import numpy as np

    from sloop_ppl.maps import bundled_maps
    from sloop_ppl.web import prepare_study

    names = [name for name in (maps or "").split(",") if name] or bundled_maps()
    study = prepare_study(names, per_map, people, rng=np.random.default_rng(seed), seed=seed)
    study.save(out)
    payload = {"out": str(out), "configurations": len(study.configurations), "people": people}
    line = f"{out}: {len(study.configurations)} configurations, for {people} people each"
    print_json(payload) if json else print_data(line)


@collect_app.command("export")
def export(
    answers: Answers,
    out: Annotated[
        Path, typer.Option(help="The description file to write, .jsonl.", show_default=False)
    ],
    only_checked: Annotated[
        bool, typer.Option("--only-checked", help="Leave out what nobody has checked.")
    ] = False,
    parsed: Annotated[
        bool, typer.Option("--parsed", help="Keep relations as read where nobody checked them.")
    ] = False,
    json: Json = False,
) -> None:
    """Write what people said as a description file."""
    _need_web()
    from sloop_ppl.web import export_answers

    count = export_answers(answers, out, only_checked=only_checked, parsed=parsed)
    payload = {"out": str(out), "descriptions": count}
    print_json(payload) if json else print_data(f"{out}: {count} descriptions")


def _need_web() -> None:
    for name in ("starlette", "uvicorn"):
        if find_spec(name) is None:
            raise InputError(
                f"The workbench needs {name}, which is not installed; run pip install "
                "'sloop-ppl[web]'"
            )
