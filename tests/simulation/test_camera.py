"""Pictures, back-projection and detectors."""

import gc
import math

import numpy as np
import pytest

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import CityMap, Grid, load_map
from sloop_ppl.simulation import (
    DETECTORS,
    Camera,
    Drone,
    Look,
    Pinhole,
    VehiclePose,
    World,
    make_detector,
)
from sloop_ppl.simulation._mujoco import rendering_fault

CALM = {"drift_m": 0.0, "noise_m": 0.0, "yaw_drift_rad": 0.0}
FIELD = CityMap("field", Grid.square(60.0), ())


def seen_from(world, x, y, yaw, altitude=14.0, **options):
    return Drone(world, (x, y, yaw), altitude_m=altitude, rng=np.random.default_rng(1), **options)


def test_a_pixel_and_its_point_on_the_ground_belong_together():
    lens, rng = Pinhole(480, 360, 76.0, -55.0), np.random.default_rng(0)
    for x, y, z, yaw in rng.uniform((-50, -50, 5, -4), (50, 50, 30, 4), (50, 4)):
        pose = VehiclePose(x, y, z, yaw)
        column, row = rng.uniform((0, 0), (480, 360))
        found = lens.ground_point(column, row, pose, z_m=0.5)
        if found is not None:
            ((c, r),) = lens.project(np.array([[found[0], found[1], 0.5]]), pose)
            assert (c, r) == pytest.approx((column, row), abs=1e-6)
            assert found[2] == pytest.approx(math.dist((*found[:2], 0.5), pose[:3]))


def test_the_middle_of_a_picture_that_looks_down_is_below():
    lens = Pinhole(100, 100, 60.0, -90.0)
    assert lens.ground_point(50, 50, VehiclePose(3, 4, 10, 1.0))[:2] == pytest.approx((3, 4))
    # Looking east from above, north is to the left.
    x, y, _ = lens.ground_point(40, 50, VehiclePose(0, 0, 10, 0.0))
    assert (x, y > 0) == (pytest.approx(0.0), True)
    assert Pinhole(100, 100, 60.0, 0.0).ground_point(50, 40, VehiclePose(0, 0, 10)) is None


def test_the_whole_fan_is_in_the_picture():
    lens = Pinhole(600, 360, 76.0, -55.0)
    for altitude in (10.0, 14.0):
        pose = VehiclePose(0, 0, altitude, 0.0)
        fan = [
            (r * math.cos(a), r * math.sin(a), 0.8)
            for r in (2.5, 10.0, 17.5)
            for a in np.radians((-45, 0, 45))
        ]
        pixels = lens.project(np.array(fan), pose)
        assert (pixels > 5).all()
        assert (pixels < (595, 355)).all()


@pytest.mark.parametrize("name", ["rays", "oracle", "segmentation", "camera"])
def test_targets_are_put_where_they_stand(request, name):
    """From eight sides and several distances, half a metre at most with a true pose."""
    if name in ("segmentation", "camera"):
        request.getfixturevalue("rendering")
    places = {"RedCar": (0.0, 0.0), "GreenBike": (3.5, -2.0), "BlueVan": (-4.0, 4.0)}
    world = World.from_map(FIELD, places, parked=0)
    seen, errors = 0, []
    for k in range(8):
        angle = k * math.pi / 4
        reach = 9.0 + 0.5 * k
        x, y = -reach * math.cos(angle), -reach * math.sin(angle)
        with Camera(world, seen_from(world, x, y, angle, **CALM)) as camera:
            for found in make_detector(name, camera).detect():
                seen += 1
                errors.append(math.dist(found.place, places[found.target]))
                assert 0 < found.share <= 1
    assert seen == 24
    assert max(errors) < 0.75
    assert np.mean(errors) < 0.35


@pytest.mark.parametrize("name", ["rays", "segmentation", "camera"])
def test_a_target_by_the_corner_of_the_picture_has_its_size(request, name):
    """From 10 m, three cells away, straight on and 45 degrees to either side."""
    if name != "rays":
        request.getfixturevalue("rendering")
    for target in ("RedCar", "BlueVan"):
        alone = World.from_map(FIELD, {target: (0.0, 0.0)}, parked=0)
        for off in (-45, -22, 0, 22, 45):
            drone = seen_from(alone, -15.0, 0.0, math.radians(off), altitude=10.0, **CALM)
            with Camera(alone, drone) as camera:
                (found,) = make_detector(name, camera).detect()
                assert math.dist(found.place, (0.0, 0.0)) < 0.9


def test_pixels_cover_equal_solid_angles_together():
    """All pixels of a picture cover the solid angle of its pyramid (Van Oosterom, Strackee)."""
    lens = Pinhole(60, 40, 80.0, -30.0)
    columns, rows = np.meshgrid(np.arange(60) + 0.5, np.arange(40) + 0.5)
    whole = sum(lens.pixel_area_m2(c, r, 1.0) for c, r in zip(columns.flat, rows.flat, strict=True))
    a, b = 30 / lens.focal_px, 20 / lens.focal_px
    exact = 4 * math.asin(a * b / math.sqrt((1 + a * a) * (1 + b * b)))
    assert whole == pytest.approx(exact, rel=2e-3)


def test_the_estimate_of_the_pose_is_what_places_rest_on(rendering):
    world = World.from_map(FIELD, {"RedCar": (0.0, 0.0)}, parked=0)
    errors = []
    for seed in range(8):
        drone = Drone(world, (-10.0, 0.0), rng=np.random.default_rng(seed))
        with Camera(world, drone) as camera:
            (found,) = make_detector("camera", camera).detect()
            strayed = np.subtract(drone.estimated_pose[:2], drone.pose[:2])
            errors.append(np.subtract(found.place, strayed))
    assert np.sqrt(np.mean(np.square(errors), axis=0)) == pytest.approx((0, 0), abs=0.5)


@pytest.mark.parametrize("name", ["rays", "oracle", "segmentation", "camera"])
def test_a_house_hides_what_is_behind_it(request, yard, name):
    if name in ("segmentation", "camera"):
        request.getfixturevalue("rendering")
    world = World.from_map(yard, {"RedCar": (7.0, 8.0)}, parked=0)
    open_side, behind = (18.0, 8.0, math.pi), (-8.0, 8.0, 0.0)
    for start, count in ((open_side, 1), (behind, 0)):
        with Camera(world, seen_from(world, *start, altitude=14.0, **CALM)) as camera:
            assert len(make_detector(name, camera).detect()) == count


def test_a_car_of_another_colour_or_size_is_no_sighting(rendering):
    world = World.from_map(FIELD, {"RedCar": (0.0, 0.0)}, parked=0)
    with Camera(world, seen_from(world, -10.0, 0.0, 0.0)) as camera:
        detector = make_detector("camera", camera)
        assert [d.target for d in detector.detect()] == ["RedCar"]
        for other in (Look("car", "blue"), Look("person", "red")):
            changed = World.from_map(FIELD, {"RedCar": (0.0, 0.0)}, looks={"RedCar": other})
            with Camera(changed, seen_from(changed, -10.0, 0.0, 0.0)) as camera_2:
                patched = make_detector("camera", camera_2)
                patched.world = world  # it believes that it looks for a red car
                assert patched.detect() == ()


def test_pictures_are_deterministic_and_coloured(rendering, yard):
    world = World.from_map(yard, {"RedCar": (10.0, 8.0)})
    with Camera(world, seen_from(world, 20.0, 8.0, math.pi)) as camera:
        one, two = camera.picture(), camera.picture()
        assert one.shape == (360, 600, 3)
        assert np.array_equal(one, two)
        assert one.std() > 10
        assert (one > 250).mean() < 0.02  # nothing is overexposed
        owners = camera.image("segmentation")
        names = world.object_names()
        assert names.index("RedCar") + 1 in owners.pixels
        assert owners.fov_deg == pytest.approx(camera.lens.horizontal_fov_deg)
        assert camera.chase().shape == (480, 640, 3)


def test_the_drone_is_not_in_its_own_picture(rendering):
    world = World.from_map(FIELD, {"RedCar": (50.0, 50.0)}, parked=0)
    with Camera(world, seen_from(world, 0.0, 0.0, 0.0), pitch_deg=-90.0) as camera:
        assert set(np.unique(camera.segmentation())) == {world.geom_owners.index("Ground")}


def test_closing_frees_the_renderer(rendering):
    world = World.from_map(FIELD, {"RedCar": (0.0, 0.0)}, parked=0)
    camera = Camera(world, seen_from(world, -10.0, 0.0, 0.0))
    camera.picture()
    (renderer,) = camera._renderers.values()
    camera.close()
    assert not camera._renderers
    assert renderer._mjr_context is None
    camera.picture()  # a picture asked for later takes it again
    camera.close()


def test_many_flights_leave_no_memory_behind():
    psutil = pytest.importorskip("psutil")
    process = psutil.Process()
    world = World.from_map(load_map("cleveland"), {"RedCar": (-45.0, -62.0)})

    def fly():
        drone = seen_from(world, -40.0, -40.0, 0.0)
        camera = Camera(world, drone)
        make_detector("rays", camera).detect()
        drone.hover(seconds=0.2)
        camera.close()

    for _ in range(5):
        fly()
    gc.collect()
    before = process.memory_info().rss
    for _ in range(40):
        fly()
    gc.collect()
    assert process.memory_info().rss - before < 40e6


def test_what_no_detector_can_be():
    world = World.from_map(FIELD, {"GreyCar": (0.0, 0.0)}, looks={"GreyCar": Look("car", "grey")})
    camera = Camera(world, seen_from(world, -10.0, 0.0, 0.0))
    with pytest.raises(UnknownName, match="Detector 'sonar' is unknown"):
        make_detector("sonar", camera)
    with pytest.raises(InputError, match="is grey, which the camera cannot tell"):
        make_detector("camera", camera)
    assert len(make_detector("rays", camera).detect()) == 1
    assert set(DETECTORS) == {"camera", "segmentation", "rays", "oracle"}


@pytest.mark.parametrize(
    ("options", "words"), [({"width": 4}, "The picture is"), ({"fov_deg": 0}, "fov_deg is 0")]
)
def test_what_no_camera_can_be(options, words):
    world = World.from_map(FIELD, {"RedCar": (0.0, 0.0)})
    with pytest.raises(InputError, match=words):
        Camera(world, seen_from(world, -10.0, 0.0, 0.0), **options)


def test_without_graphics_the_packages_are_named_and_rays_go_on(monkeypatch):
    monkeypatch.setattr("sloop_ppl.simulation.camera.rendering_fault", lambda: "none is here")
    world = World.from_map(FIELD, {"RedCar": (0.0, 0.0)})
    camera = Camera(world, seen_from(world, -10.0, 0.0, 0.0))
    with pytest.raises(InputError, match=r"none is here\); install .* libegl1 .*libosmesa6.*rays"):
        camera.picture()
    assert len(make_detector("rays", camera).detect()) == 1


@pytest.mark.parametrize(
    ("chosen", "words"),
    [
        ("osmesa", "MUJOCO_GL is osmesa, of which the library is missing"),
        ("disable", "there is neither EGL nor OSMesa"),
        ("glfw", "MUJOCO_GL is glfw, which needs a screen; set it to egl or osmesa"),
    ],
)
def test_why_there_are_no_pictures_is_said(monkeypatch, chosen, words):
    monkeypatch.setattr("sloop_ppl.simulation._mujoco._has", lambda name: name == "none")
    monkeypatch.setenv("MUJOCO_GL", chosen)
    for screen in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(screen, raising=False)
    assert rendering_fault() == words
    monkeypatch.setattr("sloop_ppl.simulation._mujoco._has", lambda name: True)
    assert rendering_fault() == {"osmesa": "", "disable": "MUJOCO_GL is disable; unset it"}.get(
        chosen, words
    )
