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


def changed(**members):
    return lambda document: document.update(members)


def in_info(**members):
    return lambda document: document["info"][0].update(members)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            changed(shape=[1_000_000, 1_000_000]),
            "field 'shape' is [1000000, 1000000]; ",
        ),
        (changed(shape=[100_000, 100_000]), "expected at most 2147483648 in all"),
        (changed(shape=[9, -11]), "field 'shape' is [9, -11]"),
        (changed(views="abc"), "field 'views' is a str; expected a list of lists of cells"),
        (lambda d: d["views"][0].append(-1), "is -1; expected a number of at least 0"),
        (lambda d: d["views"][0].append(99), "cell 99 is in view; the map has 99"),
        (lambda d: d["poses"].append([0.0, 0.0, 0.0]), "poses; expected"),
        (lambda d: d["poses"][0].__setitem__(0, float("nan")), "field 'poses[0]' is [nan, "),
        (lambda d: d["poses"][0].__setitem__(0, "1"), "field 'poses[0]' is ['1', "),
        (lambda d: d["rewards"].__setitem__(0, 1e308), "field 'rewards[0]' is 1e+308"),
        (lambda d: d["rewards"].pop(), "rewards; expected"),
        (lambda d: d["observations"].pop(), "observations; expected"),
        (changed(found_targets=["C"]), "not all were searched for"),
        (lambda d: d["beliefs"][0].update(A=[[1.0]]), "the belief of A has not 9 x 11 cells"),
        (lambda d: d["beliefs"][0]["A"][0].__setitem__(0, -1.0), "field 'beliefs' is "),
        (lambda d: d["beliefs"].append({}), "of 'beliefs'"),
        (in_info(sims=-1), "field 'info[0].sims' is -1"),
        (lambda d: d.update(rewards=["x" * 10**6] * d["steps"]), "'xxxxxxxx"),
        (in_info(values=3), "field 'info[0].values'"),
        (lambda d: d["config"].update(sims="many"), "sims"),
        (lambda d: d["config"].update(sims=-3), "sims"),
        (lambda d: d["places"].update(A=[1.0]), "field 'places'"),
    ],
)
def test_what_is_damaged_in_an_episode_is_named(change, said):
    document = json.loads(json.dumps(episode_to_document(episode("random"))))
    change(document)
    with pytest.raises(InputError, match="The episode is damaged") as caught:
        episode_from_document(document)
    assert said in str(caught.value)
    assert len(str(caught.value)) < 500
    assert "\n" not in str(caught.value)
