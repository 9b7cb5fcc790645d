"""The folder of a run is complete, or not there."""

import re
from pathlib import Path

import pytest

from armside.sim.records.atomic import write_whole
from armside.sim.records.files import LARGEST_DATA, InputError, check_n_values
from armside.sim.records.run_folder import RunFolder


def test_files_appear_together_when_the_block_ends(tmp_path):
    with RunFolder("laser", seed=0, out=tmp_path / "a" / "b") as folder:
        (folder / "summary.json").write_text("{}")
        assert not folder.path.exists()
    assert [p.name for p in folder.path.iterdir()] == ["summary.json"]
    assert [p.name for p in folder.path.parent.iterdir()] == ["b"]


def test_the_default_is_a_new_folder_each_time_even_within_a_second(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    paths = set()
    for _ in range(3):
        with RunFolder("laser", seed=4) as folder:
            (folder / "summary.json").write_text("{}")
        paths.add(folder.path)
    assert len(paths) == 3
    for path in paths:
        assert path.parent == Path("runs")
        assert re.fullmatch(r"laser-\d{8}-\d{6}-4(-\d)?", path.name)
        assert (path / "summary.json").exists()


def test_an_error_in_the_block_leaves_nothing(tmp_path):
    failed = pytest.raises(KeyError)
    with failed, RunFolder("laser", seed=0, out=tmp_path / "a") as folder:
        (folder / "summary.json").write_text("{}")
        raise KeyError("x")
    assert not list(tmp_path.iterdir())


def test_an_empty_folder_and_a_link_to_one_can_be_named(tmp_path):
    empty = tmp_path / "other-disk" / "empty"
    empty.mkdir(parents=True)
    (tmp_path / "link").symlink_to(empty)
    with RunFolder("laser", seed=0, out=tmp_path / "link") as folder:
        (folder / "summary.json").write_text("{}")
        beside = (folder / "summary.json").parent.parent
    assert beside == empty.parent
    assert (tmp_path / "link").is_symlink()
    assert (empty / "summary.json").exists()


def test_a_folder_filled_meanwhile_is_not_overwritten(tmp_path):
    full = pytest.raises(OSError, match="not empty")
    with full, RunFolder("laser", seed=0, out=tmp_path / "a") as folder:
        (folder / "summary.json").write_text("mine")
        (tmp_path / "a").mkdir()
        (tmp_path / "a" / "summary.json").write_text("theirs")
    assert (tmp_path / "a" / "summary.json").read_text() == "theirs"
    assert [p.name for p in tmp_path.iterdir()] == ["a"]


def test_a_folder_that_is_not_empty_is_refused_before_anything_is_written(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "x").touch()
    with pytest.raises(InputError, match="not empty"):
        RunFolder("laser", seed=0, out=tmp_path / "a")


def test_a_results_folder_is_as_readable_as_any_other(tmp_path):
    (tmp_path / "plain").mkdir()
    with RunFolder("laser", seed=0, out=tmp_path / "a") as folder:
        (folder / "summary.json").write_text("{}")
    assert folder.path.stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_numbers_that_do_not_fit_are_refused_in_megabytes(tmp_path):
    n = LARGEST_DATA // 8
    check_n_values(tmp_path / "a.npz", n)
    said = f"a.npz unpacks to {16 * n / 1e6:.4g} MB; at most {LARGEST_DATA / 1e6:.4g} MB are read"
    with pytest.raises(InputError, match=re.escape(said)):
        check_n_values(tmp_path / "a.npz", 2 * n)
    with pytest.raises(InputError, match="unpacks"):
        check_n_values(tmp_path / "a.npz", n + 1)


def test_a_text_file_is_replaced_whole_or_not_at_all(tmp_path):
    page, same_file = tmp_path / "page.md", tmp_path / "same-file.md"
    write_whole(page, "first")
    same_file.hardlink_to(page)
    with pytest.raises(UnicodeEncodeError):
        write_whole(page, "half \udcff")
    assert page.read_text() == "first"
    write_whole(page, "second")
    assert page.read_text() == "second"
    assert same_file.read_text() == "first"
    assert sorted(tmp_path.iterdir()) == [page, same_file]
