"""Our own model: what it is made of, and the numbers it was fitted with."""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import as_file, files
from typing import Any

from sloop_ppl.models._guard import GuardedLikelihood
from sloop_ppl.models.components import Component
from sloop_ppl.models.frames import FRAME_PREDICTORS, PredictedSpread
from sloop_ppl.models.likelihoods import LIKELIHOODS
from sloop_ppl.models.presets import ObservationModel
from sloop_ppl.models.referent_gaussian import (
    REFERENT_GAUSSIAN,
    UNFITTED_REFERENT_GAUSSIAN,
)
from sloop_ppl.models.tuning import load_parameters, with_parameters

__all__ = ["BAYES", "UNFITTED_BAYES", "borrowed", "fitting_note", "unfitted"]

UNFITTED_BAYES = ObservationModel(
    name="bayes",
    components=(
        Component("product", 0.8),
        Component("no-frame", 0.2, keep_frames=False),
    ),
    likelihood=LIKELIHOODS["student-vonmises"],
    frame_prior=PredictedSpread(FRAME_PREDICTORS["ego-ctx"]),
    lapse=0.1,
    own_lapse=0.1,
    temper=0.5,
    joint_grounds=True,
    heed_distance=True,
)
"""`bayes` before its fit, with every number in the middle of its prior.

Every phrase may lapse by itself, so the paper's components for contact and proximity are not
needed; that the frame was meant otherwise by the whole description stays one. Set by hand, for
the fit to move: one description in five and one phrase in ten go wrong, and n phrases count as
n^(1 - temper), the root of n. `docs/models.md` has how far the fit moved each, and why these
components were kept."""


def _fitted() -> ObservationModel:
    with as_file(files("sloop_ppl") / "data" / "models" / "bayes.json") as path:
        return with_parameters(UNFITTED_BAYES, load_parameters(path))


BAYES = _fitted()
"""`bayes` with the numbers of ``data/models/bayes.json``, which ``sloop eval fit`` wrote."""


def borrowed(model: ObservationModel) -> tuple[str, ...]:
    """Return the numbers that a model has from `bayes`, which were fitted for its likelihood.

    Parameters
    ----------
    model
        Any model; one with a likelihood of its own that took the place of that of `bayes` keeps
        the numbers of `bayes` until it is fitted, or they are set.

    Returns
    -------
    tuple of str
        Of ``lapse``, ``own_lapse``, ``temper``, the frames' ``kappa`` and ``absolute``, and
        ``weights`` those that are still the shipped ones; none for a model whose likelihood is of
        the same type as that of `bayes`, or that is not made of `bayes`.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from sloop_ppl.models import LIKELIHOODS
    >>> borrowed(replace(BAYES, likelihood=LIKELIHOODS["gaussian-clipped"]))
    ('lapse', 'own_lapse', 'temper', 'kappa', 'absolute', 'weights')
    """
    likelihood = model.likelihood
    kind = type(likelihood.inner if isinstance(likelihood, GuardedLikelihood) else likelihood)
    if kind is type(BAYES.likelihood):
        return ()
    fitted, own = _numbers(BAYES), _numbers(model)
    return tuple(name for name, value in fitted.items() if own.get(name) == value)


def fitting_note(model: ObservationModel) -> str | None:
    """Return one line that says which numbers were fitted for another likelihood, if any were.

    It says how to fit them, too. ``sloop`` prints it where such a model is used.
    """
    names = borrowed(model)
    if not names:
        return None
    listed = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
    user = ".py:" in model.name
    command = f"sloop eval fit said.jsonl --models {model.name if user else 'FILE.py:NAME'}"
    return (
        f"note: {listed} of '{model.name}' were fitted for the likelihood of bayes, not for this "
        f"one; {command} --out numbers.json fits them, --params numbers.json takes them"
    )


def unfitted(model: ObservationModel) -> ObservationModel:
    """Return where a fit of a model starts: a fitted preset before its fit, others as they are.

    What was learnt from a city must not leak into a fit that leaves that city out, so a model
    with another likelihood gives back what it has `borrowed` of `bayes`.
    """
    if model == BAYES:
        return UNFITTED_BAYES
    if model == REFERENT_GAUSSIAN:
        return UNFITTED_REFERENT_GAUSSIAN
    names = borrowed(model)
    if not names:
        return model
    changed: dict[str, Any] = {n: getattr(UNFITTED_BAYES, n) for n in names if n in _MODEL}
    if "weights" in names:
        changed["components"] = UNFITTED_BAYES.components
    frames = {n: getattr(UNFITTED_BAYES.frame_prior, n) for n in names if n in _FRAMES}
    prior: Any = model.frame_prior
    if frames:
        changed["frame_prior"] = replace(prior, **frames)
    return replace(model, **changed)


_MODEL = ("lapse", "own_lapse", "temper")
_FRAMES = ("kappa", "absolute")


def _numbers(model: ObservationModel) -> dict[str, Any]:
    """Return what a fit of `bayes` learns beside the numbers of its likelihood, by name."""
    frames = {name: getattr(model.frame_prior, name, None) for name in _FRAMES}
    return {
        **{name: getattr(model, name) for name in _MODEL},
        **frames,
        "weights": model.components,
    }
