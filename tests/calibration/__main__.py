"""`python -m tests.calibration`: the large robot's unknown numbers, from its targets of chapter 9.

`make calibration` calls it. The search is the same for the same seed, whatever the number of cores.
With --generations 0 the numbers in the file are held against the targets.
"""

import argparse
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields
from multiprocessing import get_context
from pathlib import Path

from armside import assets
from armside.sim.cell import LARGE_CELL
from armside.sim.evaluation.check import Check
from armside.sim.records.atomic import write_whole
from armside.sim.robot.kinematics_check import cell_model
from armside.sim.robot.run import cores

from .. import evidence
from .parameters import Trim, differing, rewrite
from .search import START, checks, evaluate, score, search


def main(words: Sequence[str] | None = None) -> int:
    """Search or check, print what is found, and return 1 for a missed target or another file."""
    parser = argparse.ArgumentParser(prog="python -m tests.calibration", description=__doc__)
    parser.add_argument("--generations", type=int, default=12, help="of four candidates")
    parser.add_argument("--seed", type=int, default=0, help="of the search")
    parser.add_argument("--file", type=Path, default=assets.LARGE_ROBOT_XML, help="compared MJCF")
    parser.add_argument("--write", action="store_true", help="write the numbers into that file")
    asked = parser.parse_args(words)
    if asked.generations < 0 or not asked.file.is_file():
        parser.error("--generations must be >= 0, and --file a file")
    if asked.generations == 0:
        found, notes = checks(cell_model(LARGE_CELL, asked.file))
        return _report(found, [note.line for note in notes], [])
    best = evaluate(START)
    bar, step = evidence.progress("calibrating", asked.generations)
    with ProcessPoolExecutor(cores(), get_context("forkserver")) as pool, bar:
        for candidate in search(START, asked.generations, asked.seed, pool.map):
            best = candidate
            step()
    differs = _compared(asked.file, best.trim, asked.write)
    return _report(best.checks, [note.line for note in best.notes], differs)


def _compared(file: Path, trim: Trim, write: bool) -> list[str]:
    """What a file has otherwise than a trim, unless the trim is written into it."""
    for field in fields(trim):
        print(f"{field.name} = {getattr(trim, field.name)}")
    if not write:
        return [f"{file} has another {name}" for name in differing(file, trim)]
    write_whole(file, rewrite(file.read_text(encoding="utf-8"), trim))
    return []


def _report(found: Sequence[Check], notes: Sequence[str], differs: Sequence[str]) -> int:
    for note in notes:
        print(f"Note: {note}")
    for check in found:
        print(f"{check.verdict}: {check.id}: {check.statement}: {check.ours:.4g} ({check.band})")
    print(f"score {score(found):.4g}", *differs, sep="\n")
    return int(bool(differs) or not all(check.holds for check in found))


if __name__ == "__main__":
    sys.exit(main())
