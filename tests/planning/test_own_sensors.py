"""Sensors from outside: masks that see other things than a fan, and one that sees no mask."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.small_searches import agent_of, city_of

from sloop_ppl.errors import InputError
from sloop_ppl.maps import Grid
from sloop_ppl.planning import (
    FanSensor,
    Fast,
    MaskSensor,
    Pose,
    Pouct,
    SearchConfig,
    SearchSpace,
    fan_offsets,
    run_search,
)
from sloop_ppl.planning._search_tables import hidden_cells, visible_mass
from sloop_ppl.planning.obstacles import cells_between

SHAPE = (7, 9)
CITY = city_of(*SHAPE)
GRID = CITY.grid
X, Y = np.meshgrid(GRID.x_m, GRID.y_m)
PLANNERS = ("pouct", "pomcp", "greedy", "fast", "random")


class Disk(MaskSensor):
    """Sees all cells whose centre is near; the same wherever the robot is."""

    def __init__(self, grid, radius_m=10.0, relative=True, **rates):
        super().__init__(grid, **rates)
        self.radius_m, self.relative = radius_m, relative

    def view(self, pose):
        x, y = np.meshgrid(self.grid.x_m, self.grid.y_m)
        return np.hypot(x - pose.x_m, y - pose.y_m) <= self.radius_m


class DownwardCamera(MaskSensor):
    """Sees a square below, which is wider where the ground, higher in the east, is far below."""

    def view(self, pose):
        half = 3.0 if pose.x_m > 22.5 else 8.0
        return (np.abs(X - pose.x_m) <= half) & (np.abs(Y - pose.y_m) <= half)


class Radio:
    """Hears a beacon at one of four strengths, by its distance and its bearing off the heading."""

    levels = (None, 1, 2, 3)

    def chances(self, pose):
        """Return the probability of each level, shape (4, H, W)."""
        distance = np.hypot(X - pose.x_m, Y - pose.y_m) / 5.0
        off = np.arctan2(Y - pose.y_m, X - pose.x_m) - pose.heading_rad
        gain = 4.0 * np.exp(-distance / 4.0) * (0.6 + 0.4 * np.cos(off))
        weights = np.exp(-2.0 * (np.arange(4.0)[:, None, None] - gain) ** 2)
        return weights / weights.sum(axis=0)

    def view(self, pose):
        return np.hypot(X - pose.x_m, Y - pose.y_m) <= 8.0

    def log_likelihood(self, pose, report):
        return np.log(self.chances(pose)[self.levels.index(report)])

    def sample(self, pose, places, rng):
        chances = self.chances(pose)
        return {
            name: self.levels[rng.choice(4, p=chances[:, *GRID.cell_covering(*place)])]
            for name, place in places.items()
        }


SENSORS = {"disk": Disk(GRID), "camera": DownwardCamera(GRID), "radio": Radio()}


def search(sensor, planner, table=None, place=(38.0, 28.0), **options):
    if table is None:
        table = np.full(SHAPE, 0.2 / 63)
        table[CITY.grid.cell_at(*place)] += 0.8
    sims = 200 if planner == "fast" else 80
    options.setdefault("config", SearchConfig(sims=sims, max_steps=60))
    rng = np.random.default_rng(options.pop("seed", 0))
    options = {"start": (3.0, 3.0), "rng": rng, **options}
    return run_search({"A": table}, CITY, {"A": place}, planner=planner, sensor=sensor, **options)


@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("name", SENSORS)
def test_every_planner_searches_with_a_users_sensor(name, planner):
    steps = []
    episode = search(SENSORS[name], planner, on_step=steps.append)
    assert planner == "random" or episode.found
    if name == "radio":
        assert {step.observation["A"] for step in steps} <= set(Radio.levels)
    for step in steps:
        assert step.beliefs["A"].sum() == pytest.approx(1)
        if not step.action.startswith("find"):
            np.testing.assert_array_equal(step.view, SENSORS[name].view(step.pose))


@pytest.mark.parametrize("name", SENSORS)
def test_the_belief_after_a_step_is_bayes_rule_at_the_reported_pose(name):
    sensor = SENSORS[name]
    if name == "disk":
        rates = {"true_positive_rate": 0.8, "false_positive_rate": 0.1}
        sensor = Disk(GRID, position_noise_cells=0.7, **rates)
    belief, steps = np.random.default_rng(3).dirichlet(np.ones(63)).reshape(SHAPE), []
    config = SearchConfig(max_steps=8, max_finds=8, sims=30)
    search(sensor, "random", belief, config=config, on_step=steps.append)
    assert {step.action for step in steps} >= {"forward", "left", "find"}
    for step in steps:
        if step.action == "find":
            view = sensor.view(step.pose)
            belief = belief * (view if step.found_targets else ~view)
        else:
            belief = belief * np.exp(sensor.log_likelihood(step.pose, step.observation["A"]))
        belief = belief / belief.sum()
        np.testing.assert_allclose(step.beliefs["A"], belief, atol=1e-12)


@pytest.mark.parametrize("rates", [{}, {"true_positive_rate": 0.7, "false_positive_rate": 0.2}])
@pytest.mark.parametrize("noise", [0.0, 0.8])
def test_reports_of_a_mask_have_probabilities_that_sum_to_one(rates, noise):
    sensor, pose = Disk(GRID, **rates, position_noise_cells=noise), Pose(11.0, 13.0, 0.3)
    places = [None, *zip(X.ravel().tolist(), Y.ravel().tolist(), strict=True)]
    total = sum(np.exp(sensor.log_likelihood(pose, report)) for report in places)
    np.testing.assert_allclose(total, np.ones(SHAPE))
    radio = Radio()
    total = sum(np.exp(radio.log_likelihood(pose, level)) for level in radio.levels)
    np.testing.assert_allclose(total, np.ones(SHAPE))


def test_a_reported_cell_is_the_likelier_the_nearer_in_a_straight_line():
    """By hand: exp(-d^2 / 2 sigma^2) over the cells in view, for offsets (0, 0), (0, 1), (1, 1)."""
    sensor = Disk(GRID, position_noise_cells=0.8)
    n = GRID.n_cols
    cells = np.array([30, 31, n + 31, 2 * n + 30])
    likelihood = sensor.cell_likelihood(cells, 30)
    offsets = [(0, 0), (0, 1), (1, 1), (2, 0)]
    for (row, col), chance in zip(offsets, likelihood.inside, strict=True):
        to_each = [math.exp(-((row - r) ** 2 + (col - c) ** 2) / 1.28) for r, c in offsets]
        assert chance == pytest.approx(to_each[0] / sum(to_each))


def test_a_sensor_is_exact_where_nothing_may_go_wrong():
    assert Disk(GRID).exact
    assert not Disk(GRID, true_positive_rate=0.0).exact
    assert not Disk(GRID, true_positive_rate=0.9).exact
    assert not Disk(GRID, false_positive_rate=0.1).exact
    assert not Disk(GRID, position_noise_cells=1.0).exact


def test_a_mask_reports_as_often_as_its_likelihood_says():
    sensor = Disk(GRID, 8.0, true_positive_rate=0.6, false_positive_rate=0.3)
    pose, place, n = Pose(*GRID.centre_of(3, 4)), GRID.centre_of(3, 5), 4000
    rng, counts = np.random.default_rng(2), {}
    for _ in range(n):
        report = sensor.sample(pose, {"A": place}, rng)["A"]
        counts[report] = counts.get(report, 0) + 1
    assert len(counts) == 10  # nine cells in view, and none
    for report, count in counts.items():
        chance = math.exp(sensor.log_likelihood(pose, report)[3, 5])
        # ten shares at 4.5 standard deviations: one test in 15 000 fails by chance
        assert abs(count / n - chance) < 4.5 * math.sqrt(chance * (1 - chance) / n)


def test_fast_says_that_it_fell_back_where_a_sensor_sees_no_mask_and_plans_as_pouct(caplog):
    fast = search(Radio(), "fast")
    note = "sensor Radio sees no mask; planned by pomdp_py.POUCT"
    assert {info.notes["fallback"] for info in fast.info} == {note}
    assert {info.planner for info in fast.info} == {"pouct"}
    assert note in caplog.text
    assert fast.planner == "fast"
    space = SearchSpace(GRID, ("A",), SearchConfig(sims=50), sensor=Radio())
    told = []
    for planner in (Fast(), Pouct()):
        agent = agent_of(space, {"A": np.ones(SHAPE)}, pose=0)
        action, info = planner.begin(space, rng=np.random.default_rng(0)).plan(agent)
        told.append((action, dict(info.values)))
    assert told[0] == told[1]
    assert all("fallback" not in info.notes for info in search(Disk(GRID), "fast").info)


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 6),
    st.integers(0, 8),
    st.integers(0, 7),
    st.sampled_from([1.0, 2.0, 2.5, 3.0, 5.0]),
    st.sampled_from([0.0, 1.0, 1.5]),
    st.sampled_from([30.0, 45.0, 90.0, 135.0, 180.0, 270.0, 360.0]),
)
def test_from_the_middle_of_a_cell_the_fan_is_the_one_of_offsets(row, col, heading, far, near, fov):
    pose = Pose(*GRID.centre_of(row, col), heading * math.pi / 4)
    mask = FanSensor(GRID, far, min(near, far), fov).view(pose)
    expected = np.zeros(SHAPE, dtype=bool)
    for r, c in fan_offsets(heading, far, min(near, far), fov):
        if 0 <= row + r < 7 and 0 <= col + c < 9:
            expected[row + r, col + c] = True
    np.testing.assert_array_equal(mask, expected)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 6), st.integers(0, 8), st.integers(0, 7), st.integers(0, 99))
def test_what_tall_cells_hide_is_what_stands_behind_them(row, col, heading, seed):
    tall = np.random.default_rng(seed).random(SHAPE) < 0.3
    pose = Pose(*GRID.centre_of(row, col), heading * math.pi / 4)
    free, hidden = (FanSensor(GRID, 4, 1, 135, t).view(pose) for t in (None, tall))
    for r, c in np.argwhere(free).tolist():
        between = cells_between(r - row, c - col)
        blocked = any(all(tall[row + a, col + b] for a, b in cells) for cells in between)
        assert hidden[r, c] == (not blocked)
    assert not (hidden & ~free).any()


def seen(sensor, x_m, y_m, heading_deg):
    return {tuple(c) for c in np.argwhere(sensor.view(Pose(x_m, y_m, math.radians(heading_deg))))}


def test_half_a_cell_off_the_middle_other_cells_are_near_enough():
    """Rows 0 to 8 have their centres at y = 2.5, 7.5, ..., columns at x = 2.5, 7.5, ... metres."""
    fan = FanSensor(Grid(0, 0.5, 44, 45), 2.0, 1.0, 90.0)
    at_centre = {(4, 5), (4, 6), (3, 5), (5, 5)}
    assert seen(fan, 22.5, 22.5, 0) == at_centre
    # half a cell further east: (4, 5) is half a cell away, too near; (4, 6) is 1.5 away, and the
    # corners (3, 6) and (5, 6) are hypot(1, 1.5) = 1.80 away, 34 degrees off
    assert seen(fan, 25.0, 22.5, 0) == {(4, 6), (3, 6), (5, 6)}
    # half a cell further north: rows 4 and 5 lie half a cell either side; (4, 5) and (5, 5) are
    # 1.12 away, 27 degrees off; two columns on they are 2.06 away, too far
    assert seen(fan, 22.5, 25.0, 0) == {(4, 5), (5, 5)}


def test_at_a_heading_between_two_the_borders_of_the_fan_turn_with_it():
    """From -25 to 65 degrees: the cell at -45 is out, the one at 45 in; at 63 in, at 90 out."""
    fan = FanSensor(Grid(0, 0.5, 44, 45), 2.3, 1.0, 90.0)
    straight = {(4, 5), (4, 6), (3, 5), (5, 5), (3, 6), (5, 6)}
    assert seen(fan, 22.5, 22.5, 0) == straight
    assert seen(fan, 22.5, 22.5, 20) == {(4, 5), (4, 6), (5, 5), (5, 6), (6, 5)}
    # (3, 6) is at -26.6 degrees: in from -27 degrees on, that is at a heading of 18
    assert (3, 6) in seen(fan, 22.5, 22.5, 18)
    assert seen(fan, 22.5, 22.5, 380) == seen(fan, 22.5, 22.5, 20)
    assert seen(fan, 500.0, 22.5, 180) == set()


@pytest.mark.parametrize("radius_m", [5.0, 8.0, 12.0])
def test_a_relative_view_makes_the_same_tables_as_asking_at_every_pose(radius_m):
    spaces = [
        SearchSpace(GRID, ("A",), SearchConfig(), sensor=Disk(GRID, radius_m, relative))
        for relative in (True, False)
    ]
    assert [space.hides for space in spaces] == [False, True]
    assert all(spaces[0].view(p) == spaces[1].view(p) for p in range(63 * 8))
    assert [set(fan) for fan in spaces[0].fans] == [set(fan) for fan in spaces[1].fans]
    belief = np.random.default_rng(0).dirichlet(np.ones(63))
    mass = [visible_mass(space, [belief]) for space in spaces]
    np.testing.assert_allclose(mass[0], mass[1])


@pytest.mark.parametrize("planner", ["pouct", "pomcp", "greedy", "fast"])
def test_planners_choose_alike_whether_or_not_a_view_is_called_relative(planner):
    told = [search(Disk(GRID, 10.0, r), planner, seed=6).actions for r in (True, False)]
    assert told[0] == told[1]


@pytest.mark.parametrize("planner", ["pouct", "fast", "greedy"])
def test_a_disk_that_sees_further_than_the_fan_of_the_settings(planner):
    episode = search(Disk(GRID, 22.0), planner, np.ones(SHAPE))
    assert episode.found
    assert episode.steps <= 6


@pytest.mark.parametrize("planner", ["fast", "pouct"])
def test_an_error_rate_of_a_users_sensor_is_planned_with(planner):
    sensor = Disk(GRID, true_positive_rate=0.5, false_positive_rate=0.1)
    episode = search(sensor, planner, config=SearchConfig(sims=80, max_steps=60, max_finds=9))
    assert episode.found


FILE = """
import numpy as np
from sloop_ppl.planning import MaskSensor

class Disk(MaskSensor):
    def view(self, pose):
        x, y = np.meshgrid(self.grid.x_m, self.grid.y_m)
        return np.hypot(x - pose.x_m, y - pose.y_m) <= 10.0

def disk(city):
    return Disk(city.grid)

class Broken(Disk):
    def __init__(self, city):
        super().__init__(city.grid)

    def view(self, pose):
        return 1 / 0

nothing = 3
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(FILE)
    return path


def test_a_sensor_is_taken_from_a_file(file):
    own = search(f"{file}:disk", "greedy")
    assert own.actions == search(Disk(GRID), "greedy").actions


class Narrow(Disk):
    def view(self, pose):
        return super().view(pose)[1:]


class Shades(Disk):
    def view(self, pose):
        return super().view(pose).astype(float)


class Deaf(Radio):
    def log_likelihood(self, pose, report):
        return super().log_likelihood(pose, report)[0]


@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize(
    ("sensor", "message"),
    [
        (
            Narrow(GRID),
            (
                "The view of sensor Narrow has shape (6, 9) and type bool; expected the map's "
                "cells, (7, 9), as bool"
            ),
        ),
        (
            Shades(GRID),
            (
                "The view of sensor Shades has shape (7, 9) and type float64; expected the map's "
                "cells, (7, 9), as bool"
            ),
        ),
        (
            "fan",
            "Sensor 'fan' is no file of yours; give FILE.py:NAME",
        ),
        (
            3,
            (
                "The sensor is a int; expected an object with the methods view(pose), "
                "log_likelihood(pose, report) and sample(pose, places, rng), such as a MaskSensor"
            ),
        ),
    ],
)
def test_a_sensor_that_is_none_is_one_line(sensor, message, planner):
    with pytest.raises(InputError) as error:
        search(sensor, planner)
    assert str(error.value) == message


def test_what_is_wrong_with_a_sensors_likelihood_is_one_line():
    with pytest.raises(InputError) as error:
        search(Deaf(), "greedy")
    assert str(error.value) == (
        "The log_likelihood of sensor Deaf has shape (9,); expected (7, 9), without NaN or plus "
        "infinity"
    )
    with pytest.raises(InputError) as error:
        search(Disk(GRID), "greedy", config=SearchConfig(fov_deg=45))
    assert str(error.value) == (
        "fov_deg is 45, but the sensor is a Disk, which has its own; leave fov_deg out, or the "
        "sensor"
    )


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "Broken",
            "Sensor 'mine.py:Broken' fails in view at line 18: ZeroDivisionError: division by zero",
        ),
        (
            "brken",
            (
                "Sensor of mine.py 'brken' is unknown; expected one of Disk, disk, Broken; did you "
                "mean 'Broken'?"
            ),
        ),
        (
            "nothing",
            (
                "Sensor 'mine.py:nothing' is a int; expected an object with the methods "
                "view(pose), log_likelihood(pose, report) and sample(pose, places, rng), such as "
                "a MaskSensor"
            ),
        ),
    ],
)
def test_what_is_wrong_with_a_sensor_of_a_file_is_one_line(file, name, message):
    with pytest.raises(InputError) as error:
        search(f"{file}:{name}", "greedy")
    assert str(error.value) == message


class Heard:
    """A sensor that sees no mask, with a sample that is given."""

    def __init__(self, reports):
        self.reports = reports

    def view(self, pose):
        return np.zeros(GRID.shape, dtype=bool)

    def log_likelihood(self, pose, report):
        return np.zeros(GRID.shape)

    def sample(self, pose, places, rng):
        return self.reports


@pytest.mark.parametrize("planner", ["greedy", "pouct", "pomcp", "fast"])
def test_a_sample_that_is_none_is_one_line(planner):
    with pytest.raises(InputError) as error:
        search(Heard(None), planner)
    assert str(error.value) == (
        "The sample of sensor Heard is None; expected a mapping from target to report"
    )
    with pytest.raises(InputError) as error:
        search(Heard({"A": ([1], 2)}), planner)
    assert str(error.value) == (
        "The report of 'A' by sensor Heard is a tuple, which cannot be hashed; expected a number, "
        "a tuple or None"
    )


def test_a_relative_view_of_another_shape_is_one_line():
    sensor = Narrow(GRID)
    sensor.relative = True
    with pytest.raises(InputError, match=r"has shape \(6, 9\) and type bool; expected the map's"):
        search(sensor, "fast")


class Everything(MaskSensor):
    """A sensor that sees the whole map, and in the north another half of it to each side."""

    def view(self, pose):
        mask = np.ones(GRID.shape, dtype=bool)
        mask[4:] = (self.grid.x_m > pose.x_m) == (pose.heading_rad < 3)
        return mask


def test_tables_of_a_sensor_that_sees_the_whole_map_are_its_views():
    space = SearchSpace(GRID, ("A",), SearchConfig(), sensor=Everything(GRID))
    hidden = hidden_cells(space)
    for pose in range(space.n_cells * 8):
        row, col, heading = space.decode(pose)
        shown = {
            (row + dr) * space.n_cols + col + dc
            for place, (dr, dc) in enumerate(space.fans[heading])
            if not hidden[pose, place]
        }
        assert shown == space.view(pose)
