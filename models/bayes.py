"""Our own model: what it is made of, and the numbers it was fitted with."""

from __future__ import annotations

from importlib.resources import as_file, files

from sloop_ppl.models.components import Component
from sloop_ppl.models.frames import FRAME_PREDICTORS, PredictedSpread
from sloop_ppl.models.likelihoods import LIKELIHOODS
from sloop_ppl.models.presets import Preset
from sloop_ppl.models.tuning import load_parameters, with_parameters

__all__ = ["BAYES", "UNFITTED_BAYES", "unfitted"]

UNFITTED_BAYES = Preset(
    name="bayes",
    components=(
        Component("product", 0.8),
        Component("no-frame", 0.2, keep_frames=False),
    ),
    likelihood=LIKELIHOODS["student-vonmises"],
    frame_prior=PredictedSpread(FRAME_PREDICTORS["ego-ctx"]),
    lapse=0.1,
    temper=0.5,
    joint_grounds=True,
    heed_distance=True,
)
"""`bayes` before its fit, with every number in the middle of its prior.

Every phrase may lapse by itself, so the paper's components for contact and proximity are not
needed; that the frame was meant otherwise by the whole description stays one."""


def _fitted() -> Preset:
    with as_file(files("sloop_ppl") / "data" / "models" / "bayes.json") as path:
        return with_parameters(UNFITTED_BAYES, load_parameters(path))


BAYES = _fitted()
"""`bayes` with the numbers of ``data/models/bayes.json``, which ``sloop eval fit`` wrote."""


def unfitted(model: Preset) -> Preset:
    """Return where a fit of a model starts: `bayes` before its own fit, any other as it is.

    What was learnt from a city must not leak into a fit that leaves that city out.
    """
    return UNFITTED_BAYES if model == BAYES else model
