"""Programs as people write them are read as they mean them, and keep every byte of theirs."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from armside.sim.controller.programs import read_program, read_program_file
from armside.sim.motion.instructions import ProgramError, Wait

FOLDER = Path(__file__).parent / "hand_written"
WRITTEN = {
    f"{folder.name}/{name}": wanted
    for folder in sorted(FOLDER.iterdir())
    for name, wanted in tomllib.loads((folder / "meant.toml").read_text("utf-8")).items()
}
"""By hand beside the programs: moves as [kind, x, y, z [m], speed [m/s], zone [m]] in their order,
with offsets, in their work object; a joint move to angles as [kind, "joints"]; or the refusal."""
READ = [name for name, wanted in WRITTEN.items() if "refused" not in wanted]
REFUSED = [name for name in WRITTEN if name not in READ]


@pytest.mark.parametrize("language", ["rapid", "krl", "urscript"])
def test_thirty_programs_of_each_language_are_written_by_hand(language):
    files = {
        f.name for f in (FOLDER / language).iterdir() if f.suffix in (".mod", ".src", ".script")
    }
    assert {f"{language}/{name}" for name in files} == {
        n for n in WRITTEN if n.startswith(language)
    }
    assert len(files) >= 30


@pytest.mark.parametrize("name", READ)
def test_a_program_written_by_hand_is_read_as_it_is_meant(name):
    read, wanted = read_program_file(FOLDER / name), WRITTEN[name]
    moves = [i for i in read.program.instructions if not isinstance(i, Wait)]
    assert len(read.program.instructions) - len(moves) == wanted.get("waits", 0)
    assert [type(m).__name__ for m in moves] == [m[0] for m in wanted["moves"]]
    for move, (_, *meant) in zip(moves, wanted["moves"], strict=True):
        if meant == ["joints"]:
            assert move.to.position is None
            continue
        np.testing.assert_allclose(move.to.position, meant[:3], rtol=0, atol=1e-9)
        if len(meant) > 3:
            assert move.speed.path == pytest.approx(meant[3], rel=1e-9)
            assert move.zone == pytest.approx(meant[4], rel=1e-9, abs=1e-12)
    places = [p for p in read.places if p.aim is not None]
    for key, found in (
        ("tools", {p.tool.name for p in places}),
        ("bases", {p.base.name for p in places}),
        ("external", {p.aim.external[0] for p in places if p.aim.external}),
    ):
        if key in wanted:
            assert found == set(wanted[key])


@pytest.mark.parametrize("name", READ)
def test_a_program_written_by_hand_keeps_its_bytes_but_those_of_a_moved_point(name):
    """Nothing asked for, nothing moved: equal. One point moved: only its numbers differ."""
    read = read_program_file(FOLDER / name)
    before = {t.name: (FOLDER / name).with_name(t.name).read_bytes() for t in read.texts}
    points = [p.aim.point for p in read.places if p.aim is not None]
    for moves in ({}, dict.fromkeys(points, np.zeros(3))):
        assert {t.name: t.content.encode("latin-1") for t in read.edited(moves)} == before
    if not points:
        return
    point, by = points[len(points) // 2], np.array([1e-3, -2e-3, 3e-3])
    moved = read.edited({point: by})
    after = {t.name: t.content.encode("latin-1") for t in moved}
    (changed,) = [n for n in before if after[n] != before[n]]
    start, end = point[0].start, len(before[changed]) - point[2].end
    assert after[changed][:start] == before[changed][:start]
    assert after[changed][-end:] == before[changed][-end:]
    for old, new in zip(read.places, read_program(*moved).places, strict=True):
        if old.aim is not None:
            step = by if old.aim.point == point else np.zeros(3)
            wanted = np.array(old.aim.target.position) + step
            np.testing.assert_allclose(new.aim.target.position, wanted, rtol=0, atol=0.501e-6)


@pytest.mark.parametrize("name", REFUSED)
def test_what_a_program_written_by_hand_may_not_do_is_refused_by_its_place(name):
    line, column, word = WRITTEN[name]["refused"]
    with pytest.raises(ProgramError) as caught:
        read_program_file(FOLDER / name)
    assert f", line {line}, column {column}: " in str(caught.value)
    assert word in str(caught.value)
