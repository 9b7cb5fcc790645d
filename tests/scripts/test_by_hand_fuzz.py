"""Damaged files in a folder by hand: one clear line each, and nothing of the person's is lost."""

import shutil

import numpy as np
import pytest

from armside.ilc.workbench.signals import read_signal, write_signal
from armside.scripts.shell.errors import InputError
from armside.scripts.workbench.options import LearnCfg
from armside.scripts.workbench.run_by_hand import Session

N, T, RUNS = 40, 0.01, 2
FILES = ("reference.csv", "u_0.csv", "y_0.csv", "u_1.csv", "y_1.csv")
ROWS = (
    b"nan,0.5\n",
    b"0.01,inf\n",
    b"0.5,1,2\n",
    b"-1,0\n",
    b"\xff\xfe\x00\n",
    b'"\n',
    b"1e999,1\n",
)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A folder in which two runs are done."""
    folder = tmp_path_factory.mktemp("hand")
    write_signal(folder / "reference.csv", np.linspace(0.0, 1.0, N)[:, np.newaxis], T, "r")
    for k in range(RUNS):
        session = Session.begin(cfg(folder))
        session.advance()
        u = read_signal(folder / f"u_{k}.csv").values
        write_signal(folder / f"y_{k}.csv", 0.8 * (session.reference + u), T, "y")
    return folder


def cfg(folder):
    law = ("heuristic:gamma=0.5,delta=1,cutoff=20",)
    return LearnCfg(plant=str(folder), laws=law, iterations=RUNS)


def damaged(content, rng):
    """Bytes changed, a row of another kind, rows lost, doubled or cut off, or nothing left."""
    rows = content.splitlines(keepends=True)
    at = int(rng.integers(len(rows)))
    match int(rng.integers(6)):
        case 0:
            changed = bytearray(content)
            for place in rng.integers(len(content), size=3):
                changed[place] = int(rng.integers(256))
            return bytes(changed)
        case 1:
            return b"".join([*rows[:at], ROWS[int(rng.integers(len(ROWS)))], *rows[at:]])
        case 2:
            return b"".join(rows[:at] + rows[at + 1 :])
        case 3:
            return b"".join([*rows[: at + 1], rows[at], *rows[at + 1 :]])
        case 4:
            return content[: int(rng.integers(len(content)))]
        case _:
            return rng.bytes(int(rng.choice([0, 1, 200])))


def test_200_fuzzed_files_give_finite_corrections_or_one_clear_line(whole, tmp_path):
    rng, said = np.random.default_rng(20), list[str]()
    for case in range(200):
        folder, name = tmp_path / str(case), FILES[case % len(FILES)]
        shutil.copytree(whole, folder)
        content = damaged((whole / name).read_bytes(), rng)
        (folder / name).write_bytes(content)
        try:
            state = Session.begin(cfg(folder)).advance()
        except (InputError, ValueError) as error:
            said.append(str(error))
            assert f"{case}/{name}" in said[-1] or "correction of another law" in said[-1]
        else:
            assert all(np.isfinite(u).all() for u in state.corrections)
        for file in FILES:
            kept = content if file == name else (whole / file).read_bytes()
            assert (folder / file).read_bytes() == kept
        shutil.rmtree(folder)
    assert len(said) > 100
    assert all("\n" not in each and len(each) < 400 for each in said)
