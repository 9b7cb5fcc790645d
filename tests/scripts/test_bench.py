"""Timing in turns, and how it is shown."""

import json

import pytest

from armside.scripts.benchmarks import start
from armside.scripts.benchmarks.timing import Row, interleaved
from armside.scripts.commands import bench
from armside.scripts.shell.errors import InputError


def test_every_function_is_called_in_turns():
    calls = []
    interleaved([lambda: calls.append("a"), lambda: calls.append("b")], repeats=5, min_round=0.0)
    assert calls == ["a", "b"] * 6


def test_the_median_ignores_a_turn_that_was_disturbed(monkeypatch):
    now = 0.0
    turns = iter([1.0, 1.0, 1.0, 100.0, 1.0, 1.0])

    def work():
        nonlocal now
        now += next(turns)

    monkeypatch.setattr("armside.scripts.benchmarks.timing.time.perf_counter", lambda: now)
    assert interleaved([work], repeats=5) == [1.0]


def test_a_fast_function_is_called_many_times_a_turn(monkeypatch):
    now, calls = 0.0, 0

    def work():
        nonlocal now, calls
        now += 1e-6
        calls += 1

    monkeypatch.setattr("armside.scripts.benchmarks.timing.time.perf_counter", lambda: now)
    (seconds,) = interleaved([work], repeats=1, min_round=1e-3)
    assert seconds == pytest.approx(1e-6, rel=1e-6)
    assert calls > 1000


def test_a_row_compares_our_time_with_the_peers():
    assert Row("pose", 1e-6, "pinocchio", 2e-6).ratio == 0.5
    assert Row("pose", 1e-6).ratio is None


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(2.5, "2.5 s"), (0.0123, "12.3 ms"), (4.7e-7, "470 ns"), (1.4e-6, "1.4 µs")],
)
def test_seconds_are_shown_with_a_prefix(seconds, text):
    assert bench.engineering(seconds) == text


def rows():
    return [Row("pose", 4e-7, "pinocchio", 5e-7), Row("jacobian", 1e-6)]


def test_every_benchmark_is_a_function_of_its_module():
    for name in bench.BENCHMARKS:
        assert bench.load(name).__name__ == name
    with pytest.raises(InputError, match="Did you mean start"):
        bench.load("sart")


def test_the_start_of_the_command_line_is_timed(monkeypatch):
    lines = []
    monkeypatch.setattr(start.subprocess, "run", lambda line, **_: lines.append(line[3:]))
    monkeypatch.setattr(start, "interleaved", lambda functions: [f() or 1.0 for f in functions])
    assert [row.name for row in start.start()] == ["armside --help", "armside laser --help"]
    assert lines == [["--help"], ["laser", "--help"]]


@pytest.fixture
def one_benchmark(monkeypatch):
    monkeypatch.setattr(bench, "load", lambda name: rows)
    monkeypatch.setattr(bench, "BENCHMARKS", ("kinematics",))


def test_bench_prints_times_beside_the_peers(armside, one_benchmark):
    status, out, _ = armside("bench kinematics")
    assert status == 0
    line = next(line for line in out.splitlines() if "pose" in line)
    for part in ("400 ns", "pinocchio", "500 ns", "0.8 "):
        assert part in line


def test_bench_as_json_has_the_same_numbers(armside, one_benchmark):
    _, out, _ = armside("bench --json")
    first, second = json.loads(out)["benchmarks"]["kinematics"]
    assert first == {
        "name": "pose",
        "ours": 4e-7,
        "peer": "pinocchio",
        "theirs": 5e-7,
        "ratio": 0.8,
    }
    assert second["ratio"] is None


def test_a_folder_that_is_not_empty_is_refused_before_anything_is_measured(
    armside, one_benchmark, monkeypatch, tmp_path
):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").touch()
    monkeypatch.setattr(bench, "load", lambda name: lambda: pytest.fail("measured"))
    assert armside("bench --out full").status == 2
