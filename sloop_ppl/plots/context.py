"""Draw the small picture of a landmark's surroundings that a frame network looks at."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.plots._axes import new_axes
from sloop_ppl.plots._palette import ACCENTS, INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["plot_context"]


def plot_context(
    image: NDArray[np.floating],
    *,
    frame_angle_rad: float | None = None,
    title: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw a picture in greys, dark for what counts most, south at the bottom.

    Parameters
    ----------
    image
        Greys from 0 to 1, shape (H, W), row 0 in the south; see
        :func:`sloop_ppl.models.frames.context_image`.
    frame_angle_rad
        Direction of an arrow from the landmark's middle, radians anticlockwise from east; None for
        no arrow.
    title
        Title of the axes.
    ax
        Axes to draw on; a new pyplot figure when None.

    Raises
    ------
    InputError
        When the image is no table of finite numbers.
    """
    if image.ndim != 2 or not np.isfinite(image).all():
        raise InputError(f"The picture has shape {image.shape}; expected finite greys, (H, W)")
    axes = new_axes(ax, width=2.4, height=2.6)
    axes.imshow(image, origin="lower", cmap="Greys", vmin=0, vmax=1, interpolation="nearest")
    axes.set_xticks([])
    axes.set_yticks([])
    if frame_angle_rad is not None:
        # The landmark itself is what counts most: the middle of its darkest cells.
        rows, cols = np.nonzero(image >= image.max())
        middle = float(cols.mean()), float(rows.mean())
        length = 0.25 * min(image.shape)
        tip = (
            middle[0] + length * math.cos(frame_angle_rad),
            middle[1] + length * math.sin(frame_angle_rad),
        )
        axes.annotate(
            "", xy=tip, xytext=middle,
            arrowprops={"arrowstyle": "-|>", "color": ACCENTS["frame"], "lw": 2.0},
        )  # fmt: skip
    if title:
        axes.set_title(title, fontsize=9, color=INK)
    return axes
