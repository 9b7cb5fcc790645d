"""The judge: an entry's tasks, one process each, scored by the ground truth.

A task is lost, with a reason, where the entry raises, hangs, ends, or returns something that is no
allowed correction; its robot does not move then.
"""

import hashlib
import json
import os
import platform
import re
import time
from collections.abc import Callable, Iterator, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ..notes import GROWTH
from ..records.files import InputError, check_file, reading
from .entry_process import ISOLATED, LONGEST_REASON, EntryError, EntryProcess
from .seal import Round
from .task import Task, Track
from .tracks import track as track_of

LARGEST_ENTRY = 1 << 20
"""[bytes], of an entry's file."""
SCHEMA = "armside-contest-1"
LARGEST = 10.0
"""Left of a lost task, and the most that counts of any other."""
SMALLEST = 1e-4
"""The least that counts."""
SAME = 1e-6
"""Relative difference up to which a task comes out the same on another machine."""
Row = dict[str, Any]


def play(source: str, task: Task, track: Track, entry: EntryProcess) -> Row:
    """One task: left, curve (of each run), harm, runs, seconds of the entry; reason of a loss, in a
    judged round of a fixed list: its own words could carry the task out."""
    N, n = task.given["reference"].shape
    plain, errors = task.plain(), list[float]()
    took, correction, reason = 0.0, np.zeros((N, n)), ""
    try:
        entry.load(source)
        call, of = "start", task.given
        for k in range(track.runs):
            began = time.perf_counter()
            found = entry.call(call, of, (N, n), track.seconds)
            took += time.perf_counter() - began
            if found is None:
                break
            if beyond := task.limits.exceeded(found):
                raise EntryError("beyond limits", f"run {k} is beyond the robot's limits: {beyond}")
            correction = found
            records, error = task.run(k, correction.copy())
            errors.append(error)
            call, of = "update", records
        entry.end()
    except EntryError as lost:
        reason = lost.kind if entry.judged else str(lost)
        entry.close()
    runs = len(errors)
    if not reason:  # one that returns nothing at first is left without correction
        until = track.runs if track.goes_on else max(runs, 1)
        errors += [task.run(k, correction)[1] for k in range(runs, until)]
    each = np.array(errors)
    curve = each / (plain[: len(each)] if len(plain) > 1 else plain[0])
    if not (reason or np.isfinite(curve).all()):
        reason = "not finite" if entry.judged else "a run of the robot is not finite"
    left = LARGEST if reason else track.left(each, plain)
    return {
        "left": float(np.clip(left, SMALLEST, LARGEST)),
        "curve": np.where(np.isfinite(curve), curve, LARGEST).tolist(),
        "harm": bool(reason) or bool((curve > GROWTH).any()),
        **{"runs": runs, "seconds": took, "reason": reason, "isolation": entry.isolation},
    }


def source_of(entry: Path) -> str:
    """Text of an entry's file. Raises InputError where it is no UTF-8, or larger than allowed."""
    with reading(check_file(entry, LARGEST_ENTRY)):
        return entry.read_text(encoding="utf-8")


def digest(source: str) -> str:
    """SHA-256 of an entry's file."""
    return hashlib.sha256(source.encode()).hexdigest()


def code() -> str:
    """SHA-256 of the code of armside that tasks and scores depend on."""
    import armside

    folder, hashed = Path(armside.__file__).parent, hashlib.sha256()
    for room in ("assets", "kinematics", "ilc", "sim"):
        for file in sorted((folder / room).rglob("*")):
            if file.suffix in (".py", ".xml", ".toml", ".npz"):
                hashed.update(file.relative_to(folder).as_posix().encode() + file.read_bytes())
    return hashed.hexdigest()


def judged(
    file: Path, entry: Path, track: str, round: Round, tasks: int, step: Callable[[], None]
) -> Row:
    """Play tasks 0 .. `tasks` - 1 and keep the result in a file, which is gone on from.

    Raises InputError where the file is of something else, or the entry cannot be isolated in a
    judged round.
    """
    source = source_of(entry)
    result, of = begun(entry.stem, source, track, round), track_of(track)
    if file.exists():
        before = read_result(file)
        named, own = identity(before), identity(result)
        if named[:-1] == own[:-1] and named != own:
            why = f"{entry} has changed since: delete the result, or give another --into"
            raise InputError(f"{file} is the result of another {entry.name}: {why}")
        if named != own:
            raise InputError(f"{file} is the result of something else: {named}")
        result["tasks"] = before["tasks"]
    done = {row["index"] for row in result["tasks"]}
    with EntryProcess(judged=round.judged) as process:
        for index in range(tasks):
            if index not in done:
                row = play(source, of.draw(round, index), of, process)
                result["tasks"].append({"index": index} | row)
                result["tasks"].sort(key=lambda row: row["index"])
                _write(file, result)
            step()
    return result


def begun(name: str, source: str, track: str, round: Round) -> Row:
    """A result without tasks."""
    versions = {each: version(each) for each in ("armside", "mujoco", "numpy", "scipy")}
    return {
        **{"schema": SCHEMA, "track": track, "round": round.name, "salt_sha256": round.digest},
        "entry": {"name": name, "sha256": digest(source)},
        "versions": versions | {"python": platform.python_version()},
        **{"code": code(), "tasks": []},
    }


def identity(result: Row) -> tuple[str, ...]:
    """What a result is of, its entry last; other code or versions make another result."""
    names = ("schema", "track", "round", "salt_sha256", "code", "versions")
    return *(str(result[name]) for name in names), str(result["entry"]["sha256"])


def read_result(file: Path) -> Row:
    """A result from its file. Raises InputError for another kind of file."""
    with reading(check_file(file)):
        found = json.loads(file.read_text(encoding="utf-8"))
        if found["schema"] != SCHEMA:
            raise InputError(f"{file} has the schema {found['schema']!r}, not {SCHEMA}")
        if not re.fullmatch(NAME, str(found["entry"]["name"])):
            raise InputError(f"{file}: the name of an entry has letters, digits, and - + . _ alone")
        for row in found["tasks"]:
            if not _is_row(row):
                raise InputError(f"{file} has a task that is none: {str(row)[:LONGEST_REASON]!a}")
        identity(found)
    return found


NAME = r"[\w .+-]{1,100}"


def _is_row(row: Any) -> bool:
    """A row of `play`, and of the index that it has in a result."""
    kinds = {"index": int, "harm": bool, "runs": int, "reason": str, "curve": list}
    kinds |= {"isolation": list}
    if not (isinstance(row, dict) and all(isinstance(row.get(k), t) for k, t in kinds.items())):
        return False
    numbers = [row.get("left"), row.get("seconds"), *row["curve"]]
    if not all(isinstance(each, float | int) and np.isfinite(each) for each in numbers):
        return False
    return (
        0.0 < row["left"] <= LARGEST
        and row["seconds"] >= 0.0
        and min(row["curve"], default=1.0) >= 0.0
        and len(row["reason"]) <= LONGEST_REASON
        and (row["reason"].isprintable() and all(isinstance(one, str) for one in row["isolation"]))
    )


def _write(file: Path, result: Row) -> None:
    partial = file.with_name(f".{file.name}.partial")
    partial.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    os.replace(partial, file)


def gaps(result: Row, tasks: int) -> str:
    """What keeps a result from having the tasks 0 .. `tasks` - 1 once each; empty for nothing."""
    found = [row["index"] for row in result["tasks"]]
    if tasks < 1 or found != list(range(tasks)):
        lacking = len(set(range(tasks)) - {*found})
        return f"it has {len(found)} tasks and lacks {lacking} of 0 to {tasks - 1}"
    return ""


def checked(result: Row, source: str, round: Round, tasks: int) -> Iterator[str]:
    """What is wrong with a result, a line each: entry, round, code, the tasks that it must have,
    and a random tenth of them played again."""
    if result["entry"]["sha256"] != digest(source):
        yield "the entry's file is another one: its SHA-256 differs"
        return
    if (result["round"], result["salt_sha256"]) != (round.name, round.digest):
        yield f"it is of the round {result['round']}, not of {round.name}"
        return
    if result["code"] != code():
        yield f"it is of other code, of armside {result['versions']['armside']}"
    if lacking := gaps(result, tasks):
        yield lacking
        return
    of = track_of(result["track"])
    for row in result["tasks"]:
        if inconsistent := _inconsistent(row, of, judged=round.judged):
            yield f"task {row['index']}: {inconsistent}"
            return
    for row in tenth(result["tasks"]):
        with EntryProcess(judged=round.judged) as process:
            again = play(source, of.draw(round, row["index"]), of, process)
        wrong = [name for name in COMPARED if not _same(again[name], row[name])]
        if bool(again["reason"]) != bool(row["reason"]):
            wrong.append("reason")
        if wrong:
            first = wrong[0]
            said = f"task {row['index']}: {first} is {again[first]}, not {row[first]}"
            yield f"{said} {again['reason']}".rstrip()


def _inconsistent(row: Row, of: Track, *, judged: bool) -> str:
    """What of a row contradicts the rest of it; empty for nothing."""
    lost, curve = bool(row["reason"]), np.array(row["curve"])
    if judged and not {*row["isolation"]} >= ISOLATED:
        return "it was played without the isolation of a judged round"
    if bool(row["harm"]) != (lost or bool((curve > GROWTH).any())):
        return f"harm is {row['harm']}, which is not that of its curve"
    if lost or len(curve) == 0:
        return "" if lost and row["left"] == LARGEST else "left is not that of a lost task"
    # Where each run has an error without correction of its own, the curve does not say it.
    left = row["left"] if of.goes_on else of.left(curve, np.ones(1))
    if not _same(float(np.clip(left, SMALLEST, LARGEST)), row["left"]):
        return f"left is {row['left']}, which is not that of its curve"
    return ""


COMPARED = ("left", "harm", "runs", "curve")
"""Of a task that is played again; seconds differ, and reasons are words."""


def _same(one: Any, other: Any) -> bool:
    return np.shape(one) == np.shape(other) and np.allclose(one, other, rtol=SAME, atol=0.0)


def tenth(tasks: Sequence[Row]) -> list[Row]:
    """A random tenth, rounded up, another each time."""
    chosen = np.random.default_rng().choice(len(tasks), -(-len(tasks) // 10), replace=False)
    return [tasks[i] for i in sorted(chosen)]
