"""`sloop ask`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli._options import (
    Area,
    Hearer,
    Json,
    MaybeMap,
    MaybeText,
    Model,
    Targets,
    Viewpoint,
)
from sloop_ppl.cli._output import print_data, print_json, progress
from sloop_ppl.errors import InputError

__all__ = ["ask"]


def ask(
    text: MaybeText = None,
    map_: MaybeMap = None,
    posterior: Annotated[
        Path | None, typer.Option(help="A saved posterior to ask about; TEXT adds to it.")
    ] = None,
    n: Annotated[int, typer.Option(help="How many questions.")] = 3,
    kind: Annotated[
        list[str] | None,
        typer.Option(
            help="A kind of question, see `sloop list questions`; may be repeated; else all.",
            show_default=False,
        ),
    ] = None,
    answer_error: Annotated[
        float, typer.Option(help="How often an answer is taken to be wrong.")
    ] = 0.1,
    targets: Targets = None,
    model: Model = "bayes",
    viewpoint: Viewpoint = "map",
    hearer: Hearer = None,
    area: Area = None,
    json: Json = False,
) -> None:
    """Say which questions are worth asking about where something is."""
    import numpy as np

    from sloop_ppl.bridge._formatting import question_lines
    from sloop_ppl.bridge._requests import posterior_of, saved_posterior
    from sloop_ppl.bridge._typed import read_hearer
    from sloop_ppl.bridge.asking import AnswererModel
    from sloop_ppl.bridge.asking import ask as find_questions
    from sloop_ppl.bridge.asking.answerers import question_json

    rng = np.random.default_rng(0)
    if posterior is not None:
        known = saved_posterior(posterior, map_, text, rng)
    elif text is None or map_ is None:
        missing = "argument 'TEXT'" if text is None else "option '--map'"
        raise InputError(f"Missing {missing}; say where something is on a map, or give --posterior")
    else:
        known = posterior_of(
            text, map_, targets=targets, model=model, viewpoint=viewpoint,
            hearer=read_hearer(hearer), rng=rng, area=area,
        )  # fmt: skip
    person = AnswererModel(error=answer_error)
    found = find_questions(known, known.city, n, kinds=kind, person=person)
    if not found:
        progress("nothing is worth asking: no answer would tell a hundredth of a bit")
    if json:
        print_json({"questions": [question_json(question) for question in found]})
    else:
        print_data(*question_lines(found))
