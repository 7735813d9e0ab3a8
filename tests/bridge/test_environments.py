"""A search of a posterior in an environment from outside, which speaks of every target."""

from __future__ import annotations

import numpy as np
import pytest

import sloop_ppl as sloop
from sloop_ppl.errors import InputError
from sloop_ppl.planning import ExactMotion, FanSensor, Outcome, Pose, Report, SearchConfig

TEXT = "The red bike is south of Velvet Dog. The green toyota is east of Velvet Dog."
PLACES = {"RedBike": (-37.5, -72.5), "GreenToyota": (22.5, -42.5)}


class Robot:
    """A robot that knows its place, and reports everything that it sees."""

    def __init__(self, city):
        self.grid, self.pose = city.grid, Pose(2.5, 2.5)
        self.sensor, self.motion = FanSensor(city.grid), ExactMotion(city.grid.cell_m)

    def execute(self, action):
        if action.name == "find":
            view = self.sensor.view(self.pose)
            found = tuple(t for t, at in PLACES.items() if view[self.grid.cell_at(*at)])
            return Outcome(self.pose, Report(found=found))
        after = self.motion.sample(self.pose, action.name, None)
        if self.grid.contains(after.x_m, after.y_m):
            self.pose = after
        return Outcome(self.pose, Report(self.sensor.sample(self.pose, PLACES, None)))


@pytest.fixture(scope="module")
def posterior():
    return sloop.infer(TEXT, "cleveland")


def search(posterior, environment, **options):
    return sloop.search(
        posterior,
        posterior.city,
        environment=environment,
        rng=np.random.default_rng(1),
        **options,
    )


def test_one_at_a_time_what_is_reported_of_the_other_target_is_not_heard(posterior):
    episode = search(posterior, Robot(posterior.city), one_at_a_time=True)
    assert episode.found
    assert set(episode.found_targets) == set(PLACES)


def test_a_search_goes_on_in_an_environment_that_still_reports_what_was_found(posterior):
    episode = search(posterior, Robot(posterior.city), config=SearchConfig(max_steps=25))
    for seed in range(8):
        episode = episode.go_on(25, rng=np.random.default_rng(seed))
    assert episode.found
    assert episode.steps > 25


def test_an_environment_that_is_none_is_one_line_in_each_leg(posterior):
    with pytest.raises(InputError, match="The environment is a int; expected an object with a"):
        search(posterior, 3, one_at_a_time=True)
    robot = Robot(posterior.city)
    robot.execute = lambda action: None
    with pytest.raises(InputError, match="The environment returned None for"):
        search(posterior, robot, one_at_a_time=True)
