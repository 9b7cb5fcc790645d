"""A claim as data, and the engine that runs its cases, judges their rows and keeps what is done."""

import hashlib
import os
import pickle
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from armside.sim.evaluation.check import Check as Check
from armside.sim.evaluation.check import Table as Table
from armside.sim.evaluation.check import all_hold as all_hold
from armside.sim.notes import Tally as Tally
from armside.sim.robot.run import cores

ROOT = Path(__file__).parents[2]
JUDGED = ("assets", "kinematics", "ilc", "sim", "scripts", "tests/claims")
"""Folders that a result depends on."""
Row = Mapping[str, Any]
"""Cells by the keys of the columns; what begins with an underscore is for the checks alone."""
Outcome = tuple[list[Row], Tally]


class Rows:
    """Rows of all cases, and their columns as arrays."""

    def __init__(self, rows: Iterable[Row]) -> None:
        self.rows = list(rows)

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, key: str) -> np.ndarray:
        """One column, (n,)."""
        return np.array([row[key] for row in self.rows])

    def of(self, *keys: str) -> np.ndarray:
        """Several columns of numbers, (n, number of keys)."""
        return np.array([[row[key] for key in keys] for row in self.rows], dtype=np.float64)

    def joined(self, key: str) -> np.ndarray:
        """A column of arrays, one after the other."""
        return np.concatenate([row[key] for row in self.rows])

    def by(self, key: str) -> dict[Any, "Rows"]:
        """The rows of each value of a column, in order of their first."""
        values = dict.fromkeys(row[key] for row in self.rows)
        return {v: Rows(row for row in self.rows if row[key] == v) for v in values}


@dataclass(frozen=True, kw_only=True)
class Claim:
    """Statements about many seeds, and how each case of them is run.

    run: called with a case and with the tally that counts the notes of its runs, in a process of
    its own; so it is a function of a module, and its cases are plain values.
    """

    title: str
    """`{n}` stands for the number of seeds."""
    seeds: int
    """Number of seeds of the full instance, counted up from 0."""
    run: Callable[[Any, Tally], Iterable[Row]]
    checks: Callable[[Rows], Iterable[Check]]
    cases: Callable[[Sequence[int]], Iterable[Any]] = tuple
    """Cases of the seeds: one for each, unless the claim crosses them with something else."""
    columns: Mapping[str, str] = field(default_factory=dict)
    """Heads of the columns by their keys; of all keys if empty, which are then the heads."""
    shown: Callable[[Rows], Iterable[Row]] = iter
    """Rows of the page: those of the cases, or a summary of them."""
    counted: str = "runs"
    """What notes are counted of."""
    processes: int | None = None
    """All cores if None; 1 for cases that have workers or threads of their own."""
    figure: Callable[[Path, Table], None] | None = None
    """Draws the table into a PNG beside the page."""


def crossed(*others: Iterable[Any]) -> Callable[[Sequence[int]], Iterable[tuple[Any, ...]]]:
    """Cases of each seed with each of the other values."""
    return lambda seeds: product(seeds, *others)


def at_once(seeds: Sequence[int]) -> list[tuple[int, ...]]:
    """One case of all seeds: they share what is expensive, or a rollout."""
    return [tuple(seeds)]


def at_most(statement: str, value: float, bar: float, form: str = ".3f", label: str = "") -> Check:
    """The check that a value is not above its bar, with both in its words."""
    words = f"{statement}: at most {bar:g} ({label}{value:{form}})"
    return Check("", words, "", value, high=bar)


def between(statement: str, value: float, low: float, high: float) -> Check:
    """The check that a value lies between two bars, ends included, with all in its words."""
    words = f"{statement}: {low:g} to {high:g} ({value:.3f})"
    return Check("", words, "", value, low=low, high=high)


def at_least(statement: str, value: float, bar: float) -> Check:
    """The check that a value is not below its bar, with both in its words."""
    return Check("", f"{statement}: at least {bar:g} ({value:.3f})", "", value, low=bar)


def within(values: np.ndarray, low: float, high: float) -> bool:
    """True if all values lie between the ends, which are left out."""
    return bool(((values > low) & (values < high)).all())


def judged(
    claim: Claim,
    seeds: Sequence[int],
    *,
    processes: int | None = 1,
    kept: Path | None = None,
    step: Callable[[], None] = lambda: None,
) -> Table:
    """Run the cases of some seeds and judge them.

    kept: folder where each case is stored as it ends, and found by the next call with the same
    code. step: called at the end of each case.
    """
    cases, tally = list(claim.cases(seeds)), Tally()
    outcomes = dict(_outcomes(claim, cases, processes, kept, step))
    for i in range(len(cases)):
        tally.include(outcomes[i][1])
    rows = Rows(row for i in range(len(cases)) for row in outcomes[i][0])
    return tabled(claim, rows, len(seeds), tally)


def tabled(claim: Claim, rows: Rows, n_seeds: int = 1, tally: Tally | None = None) -> Table:
    """The table of a claim for rows of its cases."""
    shown = list(claim.shown(rows))
    columns = claim.columns or {key: key for key in shown[0] if not key.startswith("_")}
    return Table(
        claim.title.replace("{n}", str(n_seeds)),
        list(columns.values()),
        [[row[key] for key in columns] for row in shown],
        list(claim.checks(rows)),
        [] if tally is None else tally.notes(claim.counted),
    )


def _outcomes(
    claim: Claim,
    cases: Sequence[Any],
    processes: int | None,
    kept: Path | None,
    step: Callable[[], None],
) -> Iterator[tuple[int, Outcome]]:
    """Place and outcome of each case, as they end."""
    files = {} if kept is None else _files(cases, kept)
    missing = list(range(len(cases)))
    for i, file in files.items():
        if file.exists():
            missing.remove(i)
            step()
            yield i, pickle.loads(file.read_bytes())
    for i, outcome in _run_all(claim, [(i, cases[i]) for i in missing], processes):
        if i in files:
            _store(files[i], outcome)
        step()
        yield i, outcome


def _run_all(
    claim: Claim, numbered: Sequence[tuple[int, Any]], processes: int | None
) -> Iterator[tuple[int, Outcome]]:
    count = min(processes or claim.processes or cores(), len(numbered))
    if count <= 1 or claim.processes == 1:
        yield from ((i, _run(claim.run, case)) for i, case in numbered)
        return
    # A fork copies locks of threads, not the threads: workers are started afresh.
    with ProcessPoolExecutor(count, mp_context=get_context("forkserver")) as pool:
        places = {pool.submit(_run, claim.run, case): i for i, case in numbered}
        try:
            yield from ((places[done], done.result()) for done in as_completed(places))
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _run(run: Callable[[Any, Tally], Iterable[Row]], case: Any) -> Outcome:
    tally = Tally()
    return list(run(case, tally)), tally


def _files(cases: Sequence[Any], kept: Path) -> dict[int, Path]:
    folder = kept / code()
    folder.mkdir(parents=True, exist_ok=True)
    digests = (hashlib.sha256(repr(case).encode()).hexdigest()[:16] for case in cases)
    return {i: folder / f"{digest}.pickle" for i, digest in enumerate(digests)}


def _store(file: Path, outcome: Outcome) -> None:
    partial = file.with_suffix(".partial")
    partial.write_bytes(pickle.dumps(outcome))
    os.replace(partial, file)


def code(root: Path = ROOT) -> str:
    """Digest of all files that a result depends on."""
    hashed = hashlib.sha256()
    for file in sorted(file for folder in JUDGED for file in (root / folder).rglob("*")):
        if file.suffix in (".py", ".xml", ".toml", ".json", ".npz"):
            hashed.update(file.relative_to(root).as_posix().encode() + b"\0" + file.read_bytes())
    return hashed.hexdigest()[:16]
