"""From a segmentation to places on the ground: which pixels show an object, and where it stands."""

from __future__ import annotations

import io
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError

__all__ = ["Camera", "ground_point", "middle_of", "pixels_of"]


class Camera(NamedTuple):
    """A pinhole camera on the map.

    Parameters
    ----------
    place_m
        x, y and z of the camera, metres.
    axes
        Matrix from forward, right and down to east, north and up, shape (3, 3).
    fov_deg
        Horizontal opening, degrees.
    width, height
        Size of its pictures, pixels.
    """

    place_m: tuple[float, float, float]
    axes: NDArray[np.float64]
    fov_deg: float
    width: int
    height: int


def pixels_of(png: bytes) -> NDArray[np.uint8]:
    """Return red, green and blue of a PNG file, shape (height, width, 3).

    Raises
    ------
    InputError
        When it is none.
    """
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(io.BytesIO(png), formats=["PNG"]) as image:
            return np.asarray(image.convert("RGB"))
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError) as error:
        raise InputError(
            f"AirSim's segmentation is no PNG picture ({error}); expected one of camera and type "
            "that the simulator serves"
        ) from None


def middle_of(
    pixels: NDArray[np.uint8], colour: tuple[int, int, int], min_pixels: int
) -> tuple[float, float] | None:
    """Return the mean column and row of the pixels of a colour; None if there are too few."""
    rows, columns = np.nonzero((pixels == np.array(colour, dtype=np.uint8)).all(axis=2))
    if len(rows) < min_pixels:
        return None
    return float(columns.mean()), float(rows.mean())


def ground_point(
    camera: Camera, column: float, row: float, height_m: float
) -> tuple[float, float] | None:
    """Return the place at a height above the ground that a pixel shows.

    Parameters
    ----------
    camera
        What took the picture.
    column, row
        Counted from the upper left pixel, whose middle is (0, 0).
    height_m
        Height of what is seen, metres.

    Returns
    -------
    tuple or None
        x and y in metres; None where the line of sight goes above the horizon.
    """
    focal = camera.width / 2 / math.tan(math.radians(camera.fov_deg) / 2)
    right = (column + 0.5 - camera.width / 2) / focal
    down = (row + 0.5 - camera.height / 2) / focal
    x, y, z = camera.axes @ np.array([1.0, right, down])
    if z >= -1e-6:
        return None
    along = (camera.place_m[2] - height_m) / -z
    if along <= 0:
        return None
    return float(camera.place_m[0] + along * x), float(camera.place_m[1] + along * y)
