"""A model of four components for tests of what a mixture does: the paper's, frames summed out."""

from sloop_ppl.models import (
    FRAME_PREDICTORS,
    Component,
    GaussianLikelihood,
    ObservationModel,
    PredictedSpread,
)

__all__ = ["MIXTURE"]

MIXTURE = ObservationModel(
    name="mixture",
    components=(
        Component("product", 0.6),
        Component("no-frame", 0.25, keep_frames=False),
        Component("at", 0.1, combine="sum", read_as="at"),
        Component("near", 0.05, combine="sum", read_as="near"),
    ),
    likelihood=GaussianLikelihood(),
    frame_prior=PredictedSpread(FRAME_PREDICTORS["nearest-street"]),
    joint_grounds=True,
    heed_distance=True,
)
