"""Files that others made: bounded, finite, and one line of what is wrong."""

import pytest

from sloop_ppl._foreign import ForeignFault, parse_json, parse_toml, read_text
from sloop_ppl.errors import InputError, MapError, SloopError
from sloop_ppl.inference import Posterior
from sloop_ppl.maps import load_map
from sloop_ppl.models.cell_priors import cell_prior
from sloop_ppl.outputs import check_output
from sloop_ppl.user_file import load_from_file


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[" * 100_000, "more than 64 levels"),
        ('{"a":' * 70 + "1" + "}" * 70, "more than 64 levels"),
        ("[1, NaN]", "the number NaN"),
        ("[-Infinity]", "the number -Infinity"),
        ("[1e999]", "the number 1e999"),
        ("9" * 400, "the number 99999999999999999999..."),
        ("9" * 5000, "the number 99999999999999999999..."),
        ('{"a" 1}', "Expecting ':' delimiter"),
        ("", "Expecting value"),
        ('["\\ud83d"]', "half a character"),
    ],
)
def test_json_that_cannot_be_meant(text, said):
    with pytest.raises(ForeignFault, match=said) as caught:
        parse_json(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["a = ", "a = " + "[" * 5000, "a = " + "9" * 5000, "\0", "[a\nb]"])
def test_toml_that_cannot_be_meant(text):
    with pytest.raises(ForeignFault) as caught:
        parse_toml(text)
    assert "\n" not in str(caught.value)


def test_what_is_meant_is_read():
    text = "[" * 60 + "1e300, 0.1, -7" + "]" * 60
    value = parse_json(text)
    for _ in range(59):
        (value,) = value
    assert value == [1e300, 0.1, -7]
    assert parse_json('"\\ud83d\\ude00"') == "\U0001f600"
    assert parse_toml("[model]\nlapse = 0.1\n") == {"model": {"lapse": 0.1}}


def test_a_large_file_is_not_read_to_its_end(tmp_path):
    with (tmp_path / "large").open("wb") as file:
        file.truncate(2**40)  # sparse: takes no room
    with pytest.raises(InputError, match=r"Draws '.*large' is larger than 256 MiB"):
        read_text(tmp_path / "large", "Draws")
    (tmp_path / "small").write_bytes(b"\xef\xbb\xbfabc")
    assert read_text(tmp_path / "small", "Draws", most_bytes=6) == "abc"


@pytest.mark.parametrize("name", ["absent", "x" * 300, "a\0b", "."])
def test_a_file_that_cannot_be_read(tmp_path, name):
    with pytest.raises(
        MapError, match=r"Map file '.*' cannot be read: .*; choose another"
    ) as caught:
        read_text(f"{tmp_path}/{name}", "Map file", hint="; choose another", error=MapError)
    assert len(str(caught.value)) < 400


def test_a_file_that_is_no_text(tmp_path):
    (tmp_path / "a").write_bytes(b"ab\xff")
    with pytest.raises(InputError, match=r"cannot be read: no text in UTF-8 \(byte 3\)"):
        read_text(tmp_path / "a", "Prior")


@pytest.mark.parametrize("name", ["x" * 300, "a\0b", "x" * 5000])
def test_a_name_that_can_be_no_file_is_refused_in_one_line(name):
    for use in (
        load_map,
        cell_prior,
        Posterior.load,
        lambda name: cell_prior(f"{name}.nc"),
        lambda name: load_from_file(f"{name}.py:thing", "Model", "a model", bool),
        lambda name: check_output(f"{name}.json", (".json",)),
    ):
        with pytest.raises(SloopError) as caught:
            use(name)
        assert "\n" not in str(caught.value)
