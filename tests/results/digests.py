"""Digests of what a fixed set of runs produces, for changes that must not change results.

    python tests/results/digests.py write          # of this code, into digests.json
    python tests/results/digests.py compare        # this code against digests.json
    python tests/results/digests.py compare laser  # only the runs whose name contains "laser"

Digests cover every bit, so they hold on the machine that wrote them: another CPU rounds differently
in the last digit. Write them with the code before a change, compare with the code after it. What a
run says in addition (a new key, a new column) is not a difference. Runs whose extra is missing are
left out and named.
"""

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

FILE = Path(__file__).with_name("digests.json")
DIGITS = 16
Found = dict[str, str]


class Run(NamedTuple):
    """A command line, and what of its output counts."""

    line: str
    read: Callable[[Path, str], Mapping[str, Any]]
    """Of the working folder and what was printed: named values."""
    needs: str = ""
    """Module without which the run is left out."""


def digest(value: Any) -> str:
    """Of an array or of JSON."""
    if isinstance(value, np.ndarray):
        content = str(value.dtype).encode() + str(value.shape).encode() + value.tobytes()
    else:
        content = json.dumps(value, sort_keys=True).encode()
    return hashlib.sha256(content).hexdigest()[:DIGITS]


def summary(_folder: Path, printed: str) -> dict[str, Any]:
    """Every entry of the summary but its configuration."""
    found = json.loads(printed)
    return {name: value for name, value in found.items() if name not in ("config", "format")}


def columns(table: pa.Table) -> Iterator[tuple[str, np.ndarray]]:
    """Columns of numbers, as arrays; of lists, by their items."""
    for name in table.column_names:
        column = table[name].combine_chunks()
        while pa.types.is_list(column.type):
            column = column.flatten()
        yield name, np.asarray(column.to_numpy(zero_copy_only=False)).astype(float)


def signals(folder: Path, printed: str) -> dict[str, Any]:
    """The summary, and every column of every Parquet file of the run."""
    found = summary(folder, printed)
    for file in sorted((folder / "out").glob("*.parquet")):
        for name, values in columns(pq.read_table(file)):
            found[f"{file.name}:{name}"] = values
    return found


def dataset(folder: Path, _printed: str) -> dict[str, Any]:
    """Measures of a sweep, whatever the order of its rows."""
    rows = pa.concat_tables([pq.read_table(part) for part in (folder / "into").glob("*.parquet")])
    kept = ("reached_speed", "arm_rms", "arm_maxdev", "arm_rms_true", "motor_inf", "motor_two")
    by_row = sorted(rows.select(kept).to_pylist(), key=lambda row: json.dumps(row, sort_keys=True))
    return {f"row {i}": row for i, row in enumerate(by_row)}


def checks(folder: Path, _printed: str) -> dict[str, Any]:
    """The numbers of a report, with their bands."""
    report = json.loads((folder / "out" / "report.json").read_text())
    return {
        f"{section['id']}:{check['id']}": [check["ours"], check["low"], check["high"]]
        for section in report["sections"]
        for check in section["checks"]
    }


def policy(folder: Path, _printed: str) -> dict[str, Any]:
    """Weights of a trained policy."""
    with np.load(folder / "out" / "policy.npz") as arrays:
        return {name: arrays[name] for name in arrays.files}


def code(folder: Path, _printed: str) -> dict[str, Any]:
    """Assignments of generated code; its comments may change."""
    files = [file for file in sorted((folder / "out").iterdir()) if file.suffix != ".json"]
    return {
        file.name: [line for line in file.read_text().splitlines() if " = " in line]
        for file in files
    }


_LASER = "laser --seed 1 --out out --json"
RUNS: dict[str, Run] = {
    **{
        f"laser {measure} {pose}": Run(f"{_LASER} --measure {measure} --pose {pose}", signals)
        for measure in ("motor", "estimate", "tracker")
        for pose in ("p1", "p2", "p3")
    },
    **{
        f"laser irb1400 {pose}": Run(f"{_LASER} --robot irb1400 --pose {pose}", signals)
        for pose in ("p1", "p2", "p3")
    },
    **{
        f"laser {options}": Run(f"{_LASER} --iterations 2 {options}", signals)
        for options in (
            "--shape square --lead-in spiral",
            "--shape slot --plane tool --measure estimate",
            "--shape hexagon --payload 60 --speed 30",
            "--measure estimate --law norm-optimal --pose p2",
            "--measure tracker --law heuristic",
            "--repetitions 2 --without ripple gear-error",
            "--speed 120 --radius 20 --friction-spread 5",
            "--measure estimate --stiffness-error 10 --speed 81",
            "--gamma 0.5 --delta 6 --cutoff 15",
        )
    },
    "imu irb1400": Run("imu --seed 1 --out out --json", signals),
    "imu irb1400 one after the other": Run("imu --motion sequential --out out --json", signals),
    "imu large": Run("imu --robot large --out out --json", signals),
    "imu variants": Run(
        "imu --flexibility gears --servo pid --order map-then-filter --differences central "
        "--compensation mean-at-rest --out out --json",
        signals,
    ),
    "imu at rest": Run("imu --motion rest --off 5 --on 5 --out out --json", signals),
    "identify": Run("identify --pose p2 --seed 2 --json", summary),
    "compare": Run("compare --poses p1 --speeds 40 100 --iterations 2 --json", summary),
    "design two-mass": Run("design --json", summary),
    "design servo": Run("design --model servo --json", summary),
    "tune": Run(
        "tune --episodes 2 --trials 6 --iterations 3 --sampler random --seed 3 "
        "--storage sqlite:///t.sqlite3 --json",
        summary,
    ),
    "tune tpe": Run(
        "tune --episodes 1 --trials 14 --iterations 2 --seed 5 --storage sqlite:///t.sqlite3 "
        "--json",
        summary,
    ),
    "tune estimate": Run(
        "tune --episodes 1 --trials 2 --iterations 2 --reward estimate "
        "--storage sqlite:///t.sqlite3 --json",
        summary,
    ),
    "train": Run("train --robots 4 --steps 40 --out out --json", policy, "stable_baselines3"),
    "sweep": Run(
        "sweep pose=p1,p2 gamma=0.5,0.9 measure=motor,estimate iterations=1 --into into --json",
        dataset,
    ),
    **{
        f"reproduce {name}": Run(f"reproduce {name} --seed 2 --out out --json", checks)
        for name in ("5", "8", "9.5", "9.8", "9.11", "9.17", "repeatability", "F08", "F09")
    },
    **{
        f"export {robot} {what} {to}": Run(
            f"export --robot {robot} --what {what} --to {to} --out out", code
        )
        for robot in ("irb1400", "large")
        for what, to in (("jacobian", "c"), ("pose", "python"))
    },
    "model": Run("robot model --robot large --json", summary),
}


def _environment(folder: Path) -> dict[str, str]:
    """Each run on its own core, its files in its own folder."""
    return os.environ | {
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
        "MPLCONFIGDIR": str(folder / "matplotlib"),
    }


def perform(name: str) -> tuple[str, Found]:
    """Run one and digest what it left."""
    run = RUNS[name]
    command = Path(sys.executable).with_name("armside")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        done = subprocess.run(
            [command, *run.line.split()],
            cwd=folder,
            env=_environment(folder),
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode not in (0, 1) or not (done.stdout or done.returncode == 0):
            return name, {f"failed: {done.stderr.strip()}": ""}
        found = {key: digest(value) for key, value in run.read(folder, done.stdout).items()}
    return name, found | {"status": digest(done.returncode)}


def perform_all(names: list[str]) -> dict[str, Found]:
    """All runs, two at a time."""
    results: dict[str, Found] = {}
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, found in pool.map(perform, names):
            results[name] = found
            print(f"{name}: {len(found)} values", file=sys.stderr, flush=True)
    return results


def differences(before: dict[str, Found], now: dict[str, Found]) -> list[str]:
    """Values that are other than before, or missing."""
    return [
        f"{name}: {key} {'differs' if key in now[name] else 'is missing'}"
        for name in now
        for key, known in before.get(name, now[name]).items()
        if now[name].get(key) != known or not known
    ]


def asked(words: list[str]) -> tuple[str, list[str]]:
    """What to do, and the names of the runs. Ends with status 2 and the usage for anything else."""
    parser = argparse.ArgumentParser(description="Digests of what a fixed set of runs produces.")
    parser.add_argument("what", choices=("write", "compare"))
    parser.add_argument("wanted", nargs="?", default="", help="part of the names of the runs")
    given = parser.parse_args(words)
    names = [name for name in RUNS if given.wanted in name]
    if not names:
        parser.error(f"no run's name contains {given.wanted!r}")
    return given.what, names


def main() -> int:
    what, names = asked(sys.argv[1:])
    for name in [name for name in names if RUNS[name].needs and not find_spec(RUNS[name].needs)]:
        print(f"left out: {name} needs {RUNS[name].needs}", file=sys.stderr)
        names.remove(name)
    now = perform_all(names)
    before = json.loads(FILE.read_text()) if FILE.is_file() else {}
    if what == "write":
        FILE.write_text(json.dumps(before | now, indent=1, sort_keys=True) + "\n")
        return 0
    found = differences(before, now)
    print("\n".join(found) or f"{len(now)} runs, {sum(map(len, now.values()))} values: all equal")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
