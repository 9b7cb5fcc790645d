"""Robot of the run, and its tool's path."""

from pathlib import Path

from armside.sim.records import read_run
from armside.sim.replay import film


def draw(run: Path, file: Path) -> None:
    film.picture(file, [film.stored_shots(read_run(run))])
