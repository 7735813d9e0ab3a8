"""Detectors: which targets are seen from where the drone is, and where on the ground they stand."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.simulation._airframe import SEEN_GROUP
from sloop_ppl.simulation._mujoco import mujoco
from sloop_ppl.simulation.camera import Camera
from sloop_ppl.simulation.looks import COLOURS, KIND_SIZES, Look

__all__ = [
    "DETECTORS",
    "ColourDetector",
    "Detection",
    "Detector",
    "OracleDetector",
    "RayDetector",
    "SegmentationDetector",
    "make_detector",
]


@dataclass(frozen=True)
class Detection:
    """A target that was seen.

    Parameters
    ----------
    target
        Its id.
    place
        Where it stands by the estimated pose, x and y in metres.
    share
        How much of it was seen, in (0, 1], as far as the detector can tell.
    box
        Left, top, right and bottom border in the picture, pixels; None without a picture.
    """

    target: str
    place: tuple[float, float]
    share: float
    box: tuple[int, int, int, int] | None = None


class Detector(ABC):
    """What finds targets in what a camera sees.

    Parameters
    ----------
    camera
        The camera.
    """

    needs_pictures = True

    def __init__(self, camera: Camera) -> None:
        self.camera, self.world = camera, camera.world

    @abstractmethod
    def detect(self) -> tuple[Detection, ...]:
        """Return the targets that are seen now, at most once each."""

    def _placed(
        self,
        target: str,
        column: float,
        row: float,
        share: float,
        box: tuple[int, int, int, int] | None,
    ) -> Detection | None:
        """Return a detection at a pixel, put on the ground with the estimated pose."""
        lens = self.camera.lens
        if box is not None and (
            box[0] <= 0 or box[1] <= 0 or box[2] >= lens.width or box[3] >= lens.height
        ):
            return None  # cut off by the border: its middle lies elsewhere
        height = self.world.looks[target].size_m[2]
        pose = self.camera.estimated_pose
        # The middle of what is seen of a thing lies at about half its height.
        found = lens.ground_point(column, row, pose, z_m=height / 2)
        return None if found is None else Detection(target, found[:2], share, box)


class SegmentationDetector(Detector):
    """Sees a target where enough pixels of a rendered segmentation are of it.

    Parameters
    ----------
    camera
        The camera.
    least_share
        Share of the pixels of a target in the open that must be seen.
    """

    def __init__(self, camera: Camera, least_share: float = 0.2) -> None:
        super().__init__(camera)
        self._least = least_share
        index = {name: i for i, name in enumerate(self.world.places)}
        self._table = np.array([index.get(o, -1) for o in (*self.world.geom_owners, "")])

    def detect(self) -> tuple[Detection, ...]:
        """Return the targets that are seen now."""
        owners = self._table[self.camera.segmentation()]
        found = []
        for i, name in enumerate(self.world.places):
            rows, cols = np.nonzero(owners == i)
            if not len(rows):
                continue
            share = len(rows) / _pixels_of(self.camera, name)
            made = self._placed(
                name, float(cols.mean()) + 0.5, float(rows.mean()) + 0.5, min(share, 1.0),
                _box(rows, cols),
            )  # fmt: skip
            if share >= self._least and made is not None:
                found.append(made)
        return tuple(found)


class ColourDetector(Detector):
    """Sees a target where a patch of the picture has its colour and, on the ground, its size.

    It knows what targets look like and nothing of where they are.

    Parameters
    ----------
    camera
        The camera.

    Raises
    ------
    InputError
        When a target's colour is one that cannot be distinguished from streets and walls.
    """

    def __init__(self, camera: Camera) -> None:
        super().__init__(camera)
        for name, look in self.world.looks.items():
            if _saturation(np.array(COLOURS[look.colour])) < 0.6:
                raise InputError(
                    f"Target '{name}' is {look.colour}, which the camera cannot tell from streets "
                    "and walls; sense with rays, or give it a colour such as red"
                )

    def detect(self) -> tuple[Detection, ...]:
        """Return the targets that are seen now."""
        from scipy import ndimage

        picture = self.camera.picture().astype(np.float64) / 255
        found = []
        for name, look in self.world.looks.items():
            mask = _colour_mask(picture, look.colour)
            # Gaps between the parts of one thing, as between the tubes of a bike, are closed.
            labels, count = ndimage.label(ndimage.binary_dilation(mask, iterations=2))
            labels = np.where(mask, labels, 0)
            best: Detection | None = None
            for part in range(1, count + 1):
                rows, cols = np.nonzero(labels == part)
                made = self._patch(name, look, rows, cols)
                if made is not None and (best is None or made.share > best.share):
                    best = made
            if best is not None:
                found.append(best)
        return tuple(found)

    def _patch(
        self, name: str, look: Look, rows: NDArray[np.intp], cols: NDArray[np.intp]
    ) -> Detection | None:
        """Return a detection if a patch has the size of a target."""
        if len(rows) < 4:
            return None
        lens, pose = self.camera.lens, self.camera.estimated_pose
        column, row = float(cols.mean()) + 0.5, float(rows.mean()) + 0.5
        on_ground = lens.ground_point(column, row, pose, z_m=look.size_m[2] / 2)
        if on_ground is None:
            return None
        area = len(rows) * lens.pixel_area_m2(column, row, on_ground[2])
        low, high = _AREAS_M2[look.kind]
        if not low <= area <= high:
            return None
        return self._placed(name, column, row, min(area / (high * 0.6), 1.0), _box(rows, cols))


class RayDetector(Detector):
    """Sees a target where enough rays from the camera to points on it meet nothing before it.

    Parameters
    ----------
    camera
        The camera, of which no picture is made.
    least_share
        Share of the points that must be seen.
    """

    needs_pictures = False

    def __init__(self, camera: Camera, least_share: float = 0.25) -> None:
        super().__init__(camera)
        self._least = least_share
        self._groups = np.ones(6, dtype=np.uint8)
        self._groups[SEEN_GROUP] = 0

    def detect(self) -> tuple[Detection, ...]:
        """Return the targets that are seen now."""
        found = []
        for name in self.world.places:
            points = _sample_points(self.camera, name)
            lens, pose = self.camera.lens, self.camera.pose
            pixels = lens.project(points, pose)
            inside = (
                (pixels >= 0).all(axis=1)
                & (pixels[:, 0] < lens.width)
                & (pixels[:, 1] < lens.height)
            )
            if not inside.any():
                continue
            seen = inside.copy()
            seen[inside] = self._hits(name, points[inside])
            share = float(seen.mean())
            if share < self._least:
                continue
            rows, cols = np.floor(pixels[seen, 1]), np.floor(pixels[seen, 0])
            made = self._placed(
                name, float(cols.mean()) + 0.5, float(rows.mean()) + 0.5, share, _box(rows, cols)
            )
            if made is not None:
                found.append(made)
        return tuple(found)

    def _hits(self, name: str, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which points are seen: a ray towards one meets its own target first, or nothing."""
        mj, model, data = mujoco(), self.world.model, self.camera.drone.data
        start = np.array(self.camera.pose[:3])
        ways = points - start
        lengths = np.linalg.norm(ways, axis=1)
        units = np.ascontiguousarray(ways / lengths[:, None]).ravel()
        geoms = np.full(len(points), -1, dtype=np.int32)
        reach = np.zeros(len(points))
        mj.mj_multiRay(
            model, data, start, units, self._groups, True, -1, geoms, reach, None,
            len(points), 1e3,
        )  # fmt: skip
        owners = np.array([self.world.geom_owners[g] if g >= 0 else "" for g in geoms])
        # A point on the far side is behind the near side of the same thing, which is seen.
        free = (owners == name) | (geoms < 0) | (reach >= lengths - 0.05)
        result: NDArray[np.bool_] = free
        return result


class OracleDetector(Detector):
    """Sees a target in the picture exactly, where no building stands before it; never errs."""

    needs_pictures = False

    def detect(self) -> tuple[Detection, ...]:
        """Return the targets that are seen now, at their true places."""
        lens, pose = self.camera.lens, self.camera.pose
        found = []
        for name, place in self.world.places.items():
            middle = self.world.looks[name].size_m[2] / 2
            ((column, row),) = lens.project(np.array([[*place, middle]]), pose)
            inside = 0 <= column < lens.width and 0 <= row < lens.height
            if inside and self.world.sight_is_free(pose[:3], place, middle):
                found.append(Detection(name, place, 1.0))
        return tuple(found)


DETECTORS: dict[str, type[Detector]] = {
    "camera": ColourDetector,
    "segmentation": SegmentationDetector,
    "rays": RayDetector,
    "oracle": OracleDetector,
}
"""Detectors by the name of ``sloop fly --detector``."""


def make_detector(name: str, camera: Camera) -> Detector:
    """Return a detector by name.

    Raises
    ------
    UnknownName
        When there is none of that name.
    InputError
        When it cannot see a target.
    """
    if name not in DETECTORS:
        raise UnknownName("detector", name, DETECTORS)
    return DETECTORS[name](camera)


# Least and greatest area that the coloured parts of each kind take up across the line of sight,
# square metres: partly hidden, and seen from the side that shows most.
_AREAS_M2 = {"person": (0.10, 1.4), "bike": (0.08, 1.5), "car": (1.6, 13.0), "van": (3.0, 24.0)}

_HUE_RAD = math.radians(16.0)
_LEAST_SATURATION = 0.55


def _colour_mask(picture: NDArray[np.float64], colour: str) -> NDArray[np.bool_]:
    """Return which pixels have the hue of a colour and are as saturated as paint."""
    hue, saturation = _hue(picture), _saturation(picture)
    target = _hue(np.array(COLOURS[colour]))
    off = np.abs((hue - target + math.pi) % (2 * math.pi) - math.pi)
    bright = picture.max(axis=-1) > 0.12
    mask: NDArray[np.bool_] = (off < _HUE_RAD) & (saturation > _LEAST_SATURATION) & bright
    return mask


def _hue(rgb: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the hue as an angle, radians (Preucil)."""
    r, g, b = rgb[..., 0], rgb[..., 1], rgb[..., 2]
    hue: NDArray[np.float64] = np.arctan2(math.sqrt(3) * (g - b), 2 * r - g - b)
    return hue


def _saturation(rgb: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the saturation of HSV, 0 for grey and 1 for a pure colour."""
    most, least = rgb.max(axis=-1), rgb.min(axis=-1)
    value: NDArray[np.float64] = (most - least) / np.maximum(most, 1e-6)
    return value


def _box(rows: NDArray[Any], cols: NDArray[Any]) -> tuple[int, int, int, int]:
    return int(cols.min()), int(rows.min()), int(cols.max()) + 1, int(rows.max()) + 1


def _sample_points(camera: Camera, name: str) -> NDArray[np.float64]:
    """Return points spread over a target's box, shape (27, 3)."""
    world = camera.world
    (x, y), heading = world.places[name], world.headings_rad[name]
    length, width, height = (s * 0.8 for s in KIND_SIZES[world.looks[name].kind])
    u, v, w = (a.ravel() for a in np.meshgrid([-0.5, 0, 0.5], [-0.5, 0, 0.5], [0.2, 0.5, 0.8]))
    c, s = math.cos(heading), math.sin(heading)
    return np.column_stack(
        [x + u * length * c - v * width * s, y + u * length * s + v * width * c, w * height]
    )


def _pixels_of(camera: Camera, name: str) -> float:
    """Return about how many pixels a target takes in the open, at least one."""
    world, pose = camera.world, camera.pose
    length, width, height = KIND_SIZES[world.looks[name].kind]
    x, y = world.places[name]
    way = np.array([x, y, height / 2]) - np.array(pose[:3])
    reach = float(np.linalg.norm(way))
    down = abs(float(way[2])) / reach
    # Its top as seen from this steep, and a side of middling length; half of a bike is air.
    across = length * width * down + (length + width) / 2 * height * math.sqrt(1 - down * down)
    solid = 0.5 if world.looks[name].kind in ("bike", "person") else 1.0
    ((column, row),) = camera.lens.project(np.array([[x, y, height / 2]]), pose)
    return max(solid * across / camera.lens.pixel_area_m2(column, row, reach), 1.0)
