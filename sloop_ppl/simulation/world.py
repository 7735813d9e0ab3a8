"""A city in three dimensions, made of a map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import shapely
from shapely.affinity import rotate
from shapely.geometry.base import BaseGeometry

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap
from sloop_ppl.planning.obstacles import height_m
from sloop_ppl.simulation._airframe import add_airframe
from sloop_ppl.simulation._convex import convex_pieces
from sloop_ppl.simulation._ground_picture import ground_picture
from sloop_ppl.simulation._models import add_target_model
from sloop_ppl.simulation._mujoco import mujoco
from sloop_ppl.simulation.free_places import FreeGround, Place, checked_place
from sloop_ppl.simulation.looks import Look, look_of

__all__ = ["World"]

_MARGIN_M = 30.0
_HEIGHT_SPREAD_M = 1.5
_WALLS = (
    (0.60, 0.53, 0.45), (0.55, 0.44, 0.38), (0.52, 0.50, 0.47), (0.62, 0.57, 0.50),
    (0.47, 0.42, 0.39), (0.57, 0.54, 0.52), (0.50, 0.40, 0.34), (0.45, 0.47, 0.50),
)  # fmt: skip
_PARKED_COLOURS = ("white", "silver", "grey", "black", "brown", "blue")


@dataclass(frozen=True, eq=False)
class World:
    """Buildings, ground, targets and a drone, as MuJoCo simulates them.

    Parameters
    ----------
    city
        The map; its buildings carry their height as the property ``height``, so that a planner
        that is given this map knows them as tall as they are.
    places
        Where each target stands, x and y in metres.
    looks
        What each looks like.
    headings_rad
        Which way each target and parked car faces, radians anticlockwise from east.
    parked
        Cars that nobody looks for: name -> place.
    parked_colours
        Their colours.

    Attributes
    ----------
    name
        The map's name.
    """

    city: CityMap
    places: Mapping[str, Place]
    looks: Mapping[str, Look]
    headings_rad: Mapping[str, float]
    parked: Mapping[str, Place] = field(default_factory=lambda: MappingProxyType({}))
    parked_colours: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))

    @classmethod
    def from_map(
        cls,
        city: CityMap,
        targets: Mapping[str, Place] | None = None,
        *,
        looks: Mapping[str, Look] | None = None,
        parked: int = 10,
        seed: int = 0,
    ) -> World:
        """Return the world of a map.

        Parameters
        ----------
        city
            The map. A building without a height of its own gets that of its kind, up to 1.5 m more
            or less by the seed.
        targets
            Where each target stands, x and y in metres.
        looks
            What targets look like; guessed from their ids where it is not given.
        parked
            How many cars that nobody looks for stand along the streets, in colours of no target.
        seed
            Decides heights, colours, parked cars and which way things face.

        Raises
        ------
        OutsideMap
            When a target is outside the map.
        InputError
            When a target stands inside a building, `seed` or `parked` is negative, or mujoco is not
            installed.

        Examples
        --------
        >>> from sloop_ppl.maps import load_map
        >>> world = World.from_map(load_map("cleveland"), {"GreenToyota": (-25.0, -70.0)})
        >>> world.looks["GreenToyota"].colour
        'green'
        """
        mujoco()
        for name, number in (("seed", seed), ("parked", parked)):
            if isinstance(number, bool) or not isinstance(number, int) or number < 0:
                raise InputError(f"{name} is {number!r}; expected a whole number of at least 0")
        rng = np.random.default_rng([seed, 22])
        tall = _with_heights(city, rng)
        known = {name: look_of(name) for name in targets or {}} | dict(looks or {})
        places = {}
        for name, place in (targets or {}).items():
            places[name] = checked_place(tall, name, place)
        free = FreeGround(tall)
        headings = {name: free.heading(place, rng) for name, place in places.items()}
        colours = {look.colour for name, look in known.items() if name in places}
        allowed = [c for c in _PARKED_COLOURS if c not in colours]
        spots = free.roadside(parked, [*places.values()], rng)
        cars = {f"Parked{i + 1}": spot for i, spot in enumerate(spots)}
        headings |= {name: free.heading(place, rng) for name, place in cars.items()}
        chosen = {name: allowed[int(rng.integers(len(allowed)))] for name in cars}
        return cls(
            tall, MappingProxyType(places), MappingProxyType({n: known[n] for n in places}),
            MappingProxyType(headings), MappingProxyType(cars), MappingProxyType(chosen),
        )  # fmt: skip

    @property
    def name(self) -> str:
        """Name of the map."""
        return self.city.name

    @cached_property
    def heights_m(self) -> Mapping[str, float]:
        """Height of each building, metres."""
        return MappingProxyType({b.id: height_m(b) for b in self.city.of_kind("building")})

    @cached_property
    def model(self) -> Any:
        """The compiled ``MjModel``; made when it is first asked for."""
        return self._spec().compile()

    @cached_property
    def geom_owners(self) -> tuple[str, ...]:
        """Name of what each geom belongs to: a landmark, a target, a parked car or the ground."""
        geoms = (self.model.geom(i).name for i in range(self.model.ngeom))
        return tuple(name.split("/")[0] for name in geoms)

    def object_names(self) -> tuple[str, ...]:
        """Return the names of targets, parked cars and buildings, always in the same order."""
        return (*self.places, *self.parked, *self.heights_m)

    def to_mjcf(self, path: str | Path) -> Path:
        """Write the world as MJCF, its ground as a PNG beside it.

        Parameters
        ----------
        path
            Where to write it; it ends in .xml.

        Raises
        ------
        OutputError
            When it cannot be written there.
        """
        from PIL import Image

        from sloop_ppl.outputs import check_output, written_whole

        chosen = check_output(path, (".xml",))
        picture = chosen.with_name(f"{chosen.stem}_ground.png")
        with written_whole(picture) as whole:
            Image.fromarray(ground_picture(self.city, _MARGIN_M)).save(whole)
        spec = self._spec(ground_file=picture)
        spec.compile()  # a world that does not compile is not written
        with written_whole(chosen) as whole:
            whole.write_text(spec.to_xml(), encoding="utf-8")
        return chosen

    def outline(self, target: str) -> BaseGeometry:
        """Return the rectangle that a target covers on the ground, metres.

        Examples
        --------
        >>> from sloop_ppl.maps import load_map
        >>> world = World.from_map(load_map("cleveland"), {"GreenToyota": (-25.0, -70.0)})
        >>> round(world.outline("GreenToyota").area, 2)  # 4.3 m by 1.8 m
        7.74
        """
        (x, y), (length, width, _) = self.places[target], self.looks[target].size_m
        box = shapely.box(x - length / 2, y - width / 2, x + length / 2, y + width / 2)
        return rotate(box, self.headings_rad[target], origin=(x, y), use_radians=True)

    def building_at(self, place: Place) -> str | None:
        """Return the id of the building that covers a place, the tallest of several; or None."""
        point = shapely.Point(place)
        over = [b.id for b in self.city.of_kind("building") if b.geometry.contains(point)]
        return max(over, key=lambda b: self.heights_m[b], default=None)

    def sight_is_free(self, start: tuple[float, float, float], end: Place, z_m: float) -> bool:
        """Tell whether no building stands between two points, the second `z_m` above a place."""
        near, far = np.array(start), np.array([*end, z_m])
        return not any(_hits(near, far, ring, height) for ring, height in self._prisms)

    @cached_property
    def _prisms(self) -> list[tuple[Any, float]]:
        return [
            (ring, self.heights_m[b.id])
            for b in self.city.of_kind("building")
            for ring in convex_pieces(b.geometry)
        ]

    def _spec(self, ground_file: Path | None = None) -> Any:
        mj = mujoco()
        spec = mj.MjSpec()
        spec.modelname = self.city.name
        spec.option.timestep = 0.005
        spec.option.integrator = mj.mjtIntegrator.mjINT_IMPLICITFAST
        _light(spec)
        self._add_ground(spec, ground_file)
        self._add_buildings(spec)
        for name, place in self.places.items():
            add_target_model(spec, name, self.looks[name], place, self.headings_rad[name])
        for name, place in self.parked.items():
            look = Look("car", self.parked_colours[name])
            add_target_model(spec, name, look, place, self.headings_rad[name])
        spec.worldbody.add_camera(name="eye", pos=[0.0, 0.0, 60.0])
        add_airframe(spec)
        return spec

    def _add_ground(self, spec: Any, ground_file: Path | None) -> None:
        mj = mujoco()
        texture = spec.add_texture(name="ground", type=mj.mjtTexture.mjTEXTURE_2D)
        if ground_file is not None:
            texture.file = ground_file.name
            spec.modelfiledir = str(ground_file.parent)
        else:
            # MuJoCo counts the rows of a texture from below.
            pixels = ground_picture(self.city, _MARGIN_M)
            texture.height, texture.width, texture.nchannel = pixels.shape
            texture.data = pixels.tobytes()
        material = spec.add_material(name="ground", specular=0.0, shininess=0.0)
        material.textures[mj.mjtTextureRole.mjTEXROLE_RGB] = "ground"
        west, south, east, north = self.city.grid.extent_m
        middle = [(west + east) / 2, (south + north) / 2, 0.0]
        sides = [(east - west) / 2 + _MARGIN_M, (north - south) / 2 + _MARGIN_M, 1.0]
        spec.worldbody.add_geom(
            name="Ground", type=mj.mjtGeom.mjGEOM_PLANE, pos=middle, size=sides, material="ground"
        )

    def _add_buildings(self, spec: Any) -> None:
        mj = mujoco()
        for i, colour in enumerate(_WALLS):
            material = spec.add_material(name=f"wall{i}", specular=0.05, shininess=0.1)
            material.rgba = [*colour, 1.0]
        for number, building in enumerate(self.city.of_kind("building")):
            height = self.heights_m[building.id]
            if height <= 0:
                continue
            for k, ring in enumerate(convex_pieces(building.geometry)):
                middle = ring.mean(axis=0)
                base = np.column_stack([ring - middle, np.zeros(len(ring))])
                corners = np.concatenate([base, base + np.array([0.0, 0.0, height])])
                name = f"{building.id}/{k}"
                mesh = spec.add_mesh(name=name, uservert=corners.ravel().tolist())
                mesh.inertia = mj.mjtMeshInertia.mjMESH_INERTIA_CONVEX
                spec.worldbody.add_geom(
                    name=name, type=mj.mjtGeom.mjGEOM_MESH, meshname=name,
                    pos=[*middle, 0.0], material=f"wall{number % len(_WALLS)}",
                )  # fmt: skip


def _light(spec: Any) -> None:
    """Set sun, sky and what the pictures of the world need."""
    mj = mujoco()
    sky = spec.add_texture(name="sky", type=mj.mjtTexture.mjTEXTURE_SKYBOX)
    sky.builtin = mj.mjtBuiltin.mjBUILTIN_GRADIENT
    sky.rgb1, sky.rgb2, sky.width, sky.height = [0.55, 0.70, 0.86], [0.86, 0.90, 0.94], 64, 384
    sun = spec.worldbody.add_light(name="sun", pos=[0.0, 0.0, 150.0], dir=[0.45, 0.35, -0.82])
    sun.type = mj.mjtLightType.mjLIGHT_DIRECTIONAL
    sun.ambient, sun.diffuse, sun.specular = [0.30] * 3, [0.62, 0.60, 0.55], [0.05] * 3
    # Shadows take nine tenths of the time of a picture in software.
    sun.castshadow = False
    spec.visual.headlight.ambient = [0.22, 0.23, 0.25]
    spec.visual.headlight.diffuse = [0.10] * 3
    spec.visual.headlight.specular = [0.0] * 3
    spec.visual.global_.offwidth, spec.visual.global_.offheight = 1280, 960
    spec.visual.quality.offsamples = 0
    # Near and far are shares of the extent: a narrow range keeps the depth buffer exact.
    spec.stat.extent, spec.stat.center = 200.0, [0.0, 0.0, 0.0]
    spec.visual.map.znear, spec.visual.map.zfar = 0.004, 5.0


def _with_heights(city: CityMap, rng: np.random.Generator) -> CityMap:
    """Return the map with a height in metres of each building."""
    landmarks = []
    for landmark in city.landmarks:
        if landmark.kind != "building":
            landmarks.append(landmark)
            continue
        height = height_m(landmark)
        drawn = float(rng.uniform(-_HEIGHT_SPREAD_M, _HEIGHT_SPREAD_M))
        if not {"height", "building:levels"} & set(landmark.properties):
            height = round(height + drawn, 2)
        known = MappingProxyType({**landmark.properties, "height": f"{height:g}"})
        landmarks.append(replace(landmark, properties=known))
    return replace(city, landmarks=tuple(landmarks), _cache={})


def _hits(near: Any, far: Any, ring: Any, height: float) -> bool:
    """Tell whether a line enters the prism over a convex anticlockwise ring."""
    along = far - near
    low, high = 0.0, 1.0
    # Clipped by each wall in turn and by the roof (Cyrus and Beck 1978).
    edge = np.roll(ring, -1, axis=0) - ring
    outward = np.column_stack([edge[:, 1], -edge[:, 0]])
    distance = np.append((outward * (ring - near[:2])).sum(axis=1), height - near[2])
    speed = np.append(outward @ along[:2], along[2])
    for d, s in zip(distance.tolist(), speed.tolist(), strict=True):
        if abs(s) < 1e-12:
            if d < 0:
                return False
        elif s > 0:
            high = min(high, d / s)
        else:
            low = max(low, d / s)
    return low < high
