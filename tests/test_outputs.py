"""Paths are checked before the work, and files appear whole or not at all."""

import os

import pytest

from sloop_ppl.errors import OutputError
from sloop_ppl.outputs import check_output, check_output_folder, written_whole


def test_a_good_path_is_returned(tmp_path):
    assert check_output(tmp_path / "a.PNG", (".png", ".pdf")) == tmp_path / "a.PNG"
    assert not (tmp_path / "a.PNG").exists()


def test_another_ending_is_refused(tmp_path):
    with pytest.raises(OutputError) as caught:
        check_output(tmp_path / "a.doc", (".png", ".pdf"))
    assert str(caught.value) == (
        f"Output '{tmp_path / 'a.doc'}' ends in '.doc'; expected one of .png, .pdf"
    )


def test_a_folder_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(OutputError, match="does not exist; make it first"):
        check_output(tmp_path / "no" / "a.png", (".png",))


def test_a_folder_in_place_of_the_file_is_refused(tmp_path):
    (tmp_path / "a.png").mkdir()
    with pytest.raises(OutputError, match=r"is a folder; give the name of a file$"):
        check_output(tmp_path / "a.png", (".png",))


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write anywhere")
def test_a_folder_one_may_not_write_to_is_refused(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(
        OutputError, match=r"cannot be written: (permission denied|Permission denied)"
    ):
        check_output(tmp_path / "a.png", (".png",))


def test_output_folders_are_made(tmp_path):
    assert check_output_folder(tmp_path / "a" / "b").is_dir()
    assert list((tmp_path / "a" / "b").iterdir()) == []
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot be made: Not a directory"):
        check_output_folder(tmp_path / "file" / "b")


def test_a_file_takes_its_place_when_the_work_ends_well(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with written_whole(path) as temporary:
        temporary.write_text("new")
        assert path.read_text() == "old"
        assert temporary.suffix == ".txt"
    assert path.read_text() == "new"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_the_old_file_stays_when_the_work_fails(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError):
        fail_half_way(path)
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def fail_half_way(path):
    with written_whole(path) as temporary:
        temporary.write_text("half")
        raise RuntimeError
