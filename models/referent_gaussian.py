"""A comparator: a mixture over referents, each with a fitted Gaussian about it."""

from __future__ import annotations

from importlib.resources import as_file, files

from sloop_ppl.models.components import Component
from sloop_ppl.models.frames import FRAME_PREDICTORS, PredictedSpread
from sloop_ppl.models.likelihoods import LIKELIHOODS
from sloop_ppl.models.presets import ObservationModel
from sloop_ppl.models.tuning import load_parameters, with_parameters

__all__ = ["REFERENT_GAUSSIAN", "UNFITTED_REFERENT_GAUSSIAN"]

UNFITTED_REFERENT_GAUSSIAN = ObservationModel(
    name="referent-gaussian",
    components=(Component("product"),),
    likelihood=LIKELIHOODS["gaussian-displacement"],
    frame_prior=PredictedSpread(FRAME_PREDICTORS["ego-ctx"]),
    lapse=0.1,
    temper=0.5,
    joint_grounds=True,
    heed_distance=True,
    sum_readings=False,
)
"""`referent-gaussian` before its fit.

After Language as a Sensor (arXiv 2606.08666): a phrase is a measurement of a place, a mixture over
what each of its mentions may refer to, none on the map included, of a Gaussian about the referent;
the phrases of the most probable reading multiply. It has of `bayes` the frames, said distances and
regions of words, so that what lies between the two is the shape of the kernel, the component
without frames and the sum over readings. The numbers are the middles of their priors, those of
`bayes` where it has the same number."""


def _fitted() -> ObservationModel:
    with as_file(files("sloop_ppl") / "data" / "models" / "referent-gaussian.json") as path:
        return with_parameters(UNFITTED_REFERENT_GAUSSIAN, load_parameters(path))


REFERENT_GAUSSIAN = _fitted()
"""`referent-gaussian` with the numbers that ``sloop eval fit`` found on the 64 published
descriptions, gold relations."""
