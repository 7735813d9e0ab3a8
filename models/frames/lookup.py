"""Find a frame predictor by its name or by the path of its weights."""

from __future__ import annotations

from pathlib import Path

from sloop_ppl.models.frames.learned import LearnedFrames
from sloop_ppl.models.frames.predictor import FRAME_PREDICTORS, FramePredictor
from sloop_ppl.models.frames.weights import load_weights

__all__ = ["frame_predictor"]


def frame_predictor(name_or_path: str | Path) -> FramePredictor:
    """Return the registered predictor of this name, or that of a ``.safetensors`` file.

    Raises
    ------
    UnknownName : when no predictor has this name; it lists those there are.
    InputError : when the weights cannot be used.
    """
    name = str(name_or_path)
    if name.endswith(".safetensors"):
        load_weights(name)
        return LearnedFrames(Path(name))
    return FRAME_PREDICTORS[name]
