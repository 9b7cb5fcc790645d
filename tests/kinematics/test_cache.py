"""Generated code on disk: what is damaged is made again, what others may write is not executed."""

import logging
import os
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

from armside.kinematics import Link, Robot, cache, compile
from armside.scripts.shell.runner import announce_compiling

PLANAR = Robot([Link(a=0.5), Link(a=0.25)])
EXPECTED = [0.75, 0.0, 0.0]
EVIL = "\nopen({!r}, 'w').close()\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A filled cache folder, and a process that has loaded nothing from it."""
    place = tmp_path / "cache"
    tool(place)
    monkeypatch.setattr(cache, "_LOADED", {})
    return place


def tool(place: Path) -> list[float]:
    return compile(PLANAR, cache=place).pose(np.zeros(2))[:3, 3].tolist()


def files(place: Path, ending: str) -> list[Path]:
    return sorted(path for path in place.rglob(f"*.{ending}"))


@pytest.mark.parametrize("ending", ["py", "nbi", "nbc"])
@pytest.mark.parametrize("damage", ["empty", "half", "noise"])
def test_damaged_files_are_made_again_with_a_note(folder, ending, damage, caplog):
    damaged = files(folder, ending)
    assert damaged
    for path in damaged:
        content = path.read_bytes()
        noise = bytes(255 - byte for byte in content)
        parts = {"empty": b"", "half": content[: len(content) // 2], "noise": noise}
        path.write_bytes(parts[damage])
    with caplog.at_level(logging.WARNING):
        assert tool(folder) == EXPECTED
    assert "was damaged and is" in caplog.text
    caplog.clear()
    cache._LOADED.clear()
    assert tool(folder) == EXPECTED
    assert not caplog.text


def test_what_is_compiled_is_announced_on_a_terminal_and_once(tmp_path, monkeypatch):
    """In a handler of the command line's own, whose stream is the terminal."""
    stream, log = StringIO(), logging.getLogger(cache.__name__)
    monkeypatch.setattr(log, "handlers", [])
    announce_compiling(stream, debug=False)
    assert tool(tmp_path / "new") == EXPECTED
    log.warning("damaged")
    assert stream.getvalue() == "armside: compiling pose, once on this machine\n"
    monkeypatch.setattr(cache, "_LOADED", {})
    assert tool(tmp_path / "new") == EXPECTED
    assert stream.getvalue().count("\n") == 1
    log.setLevel(logging.NOTSET)


def test_a_missing_file_of_machine_code_is_made_again(folder, caplog):
    for path in files(folder, "nbc"):
        path.unlink()
    assert tool(folder) == EXPECTED
    assert files(folder, "nbc")


@pytest.mark.parametrize("ending", ["py", "nbi", "nbc", "folder", "__pycache__"])
@pytest.mark.parametrize("fault", ["owner", "group", "others"])
def test_what_others_may_write_is_not_executed(folder, ending, fault, caplog, monkeypatch):
    places = {"folder": [folder], "__pycache__": [folder / "__pycache__"]}
    (*_, place) = places.get(ending) or files(folder, ending)
    (module,) = files(folder, "py")
    text = module.read_text().rpartition(cache._DIGEST)[0]
    cache._write(module, text + EVIL.format(str(folder / "executed")))
    if fault == "owner":
        of_somebody(place, monkeypatch)
    else:
        place.chmod(place.stat().st_mode | (0o020 if fault == "group" else 0o002))
    cache._report_foreign.cache_clear()
    with caplog.at_level(logging.WARNING):
        assert tool(folder) == EXPECTED
    assert f"compiled in memory: {place}" in caplog.text
    assert not (folder / "executed").exists()


def of_somebody(place: Path, monkeypatch) -> None:
    """Only root may give files away; others are shown another owner."""
    if os.geteuid() == 0:
        os.chown(place, 12345, 12345)
        return
    stat = Path.stat

    def shown(path: Path, **options):
        status = stat(path, **options)
        values = list(status)
        values[4] = 12345 if path == place else values[4]
        return os.stat_result(values)

    monkeypatch.setattr(Path, "stat", shown)


def test_new_folders_are_for_their_owner_alone(tmp_path):
    umask = os.umask(0)
    try:
        tool(tmp_path / "new" / "cache")
    finally:
        os.umask(umask)
    for place in (tmp_path / "new" / "cache", tmp_path / "new" / "cache" / "__pycache__"):
        assert place.stat().st_mode & 0o777 == 0o700


def test_code_that_cannot_be_stored_is_compiled_once_in_a_process(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("")
    first = cache.cached_module("once", "", lambda: "value = 1\n", blocked / "cache")
    assert cache.cached_module("once", "", lambda: "value = 2\n", blocked / "cache") is first


def test_a_cache_that_can_only_be_read_works(folder, caplog, monkeypatch):
    """Every attempt to make a file fails, as root may write anywhere."""

    def refused(*_, **__):
        raise PermissionError("read-only")

    monkeypatch.setattr("tempfile.mkstemp", refused)
    monkeypatch.setattr("tempfile.TemporaryFile", refused)
    monkeypatch.setattr("armside.kinematics.codegen.numba_module", refused)  # the text is there
    assert tool(folder) == EXPECTED
    assert not caplog.text
