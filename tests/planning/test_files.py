from __future__ import annotations

import json

import numpy as np
import pytest
from support.small_searches import city_of

from sloop_ppl.errors import InputError, OutputError
from sloop_ppl.planning import SearchConfig, read_episode, run_search, write_episode
from sloop_ppl.planning.files import episode_from_document, episode_to_document


def episode(planner="pouct", **settings):
    return run_search(
        {"A": np.ones((9, 11)), "B": np.ones((9, 11))},
        city_of(9, 11),
        {"A": (31.0, 22.0), "B": (3.0, 40.0)},
        planner=planner,
        config=SearchConfig(sims=40, max_steps=12, **settings),
        rng=np.random.default_rng(2),
        keep_beliefs=True,
    )


@pytest.mark.parametrize("planner", ["pouct", "pomcp", "fast", "greedy", "random"])
def test_an_episode_comes_back_from_its_file_as_it_was(tmp_path, planner):
    told = episode(planner)
    path = tmp_path / "episode.json"
    write_episode(told, path, model="sloop", seed=2)
    again = read_episode(path)
    assert episode_to_document(again) == episode_to_document(told)
    assert again.discounted_return == told.discounted_return
    assert again.undiscounted_return == sum(told.rewards)
    np.testing.assert_array_equal(again.views, told.views)
    np.testing.assert_array_equal(again.beliefs[-1]["B"], told.beliefs[-1]["B"])
    assert json.loads(path.read_text())["seed"] == 2
    assert [p.name for p in tmp_path.iterdir()] == ["episode.json"]


def test_a_file_that_cannot_be_written_to_the_end_leaves_the_old_one(tmp_path):
    path = tmp_path / "episode.json"
    path.write_text("old")
    with pytest.raises(UnicodeEncodeError):
        write_episode(episode("random"), path, note="\ud800")
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["episode.json"]


def test_the_file_of_a_seed_has_the_same_bytes(tmp_path):
    for name in "ab":
        write_episode(episode(), tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_an_episode_of_another_version_is_refused():
    document = {**episode_to_document(episode("random")), "version": 7}
    with pytest.raises(InputError) as error:
        episode_from_document(document)
    assert str(error.value) == (
        "The episode has version 7; this program reads version 1: search again with this "
        "program, or read it with the one that wrote it"
    )


@pytest.mark.parametrize("document", [[], {"poses": []}, {"format": "other"}, None])
def test_what_is_no_episode_is_refused(document):
    with pytest.raises(InputError, match="This is no episode; expected a JSON object whose"):
        episode_from_document(document)


@pytest.mark.parametrize("member", ["config", "poses", "views", "info", "observations", "places"])
def test_a_damaged_episode_is_refused(member):
    document = episode_to_document(episode("random"))
    del document[member]
    with pytest.raises(InputError, match="The episode is damaged"):
        episode_from_document(document)
    with pytest.raises(InputError, match="The episode is damaged"):
        episode_from_document({**document, member: [3]})


def test_files_that_cannot_be_read_or_written_are_named(tmp_path):
    with pytest.raises(InputError, match="No such file or directory; give an episode's path"):
        read_episode(tmp_path / "none.json")
    (tmp_path / "text").write_text("poses")
    with pytest.raises(InputError, match="is not JSON"):
        read_episode(tmp_path / "text")
    with pytest.raises(OutputError, match="choose another path"):
        write_episode(episode("random"), tmp_path / "no" / "folder.json")
