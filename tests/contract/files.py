"""Files that command lines name: good ones of each kind, and all kinds of bad ones."""

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from armside.assets import LARGE_ROBOT_XML
from armside.kinematics import CATALOGUE, compile
from armside.sim.robot.mjcf import N_AXES
from armside.sim.twin.identification import parameters_of
from armside.sim.twin.twin import Twin, design_of, robot_digest

_GEARS = 'version = 1\nrobot = "LARGE_ROBOT"\nmotors = 6\n[[gear_error]]\njoint = 1\norder = 220\n'
GOOD = {
    "contour.toml": "corner = 1.5\npoints = [[-10, -6], [10, -6], [10, 6], [0, 9], [-10, 6]]\n",
    "model.json": '{"sample_time": 0.004, "b": [0, 0.5], "a": [1, -0.5]}',
    "best.json": '{"best": {"gamma": 0.9, "delta": 3, "cutoff": 10.0}}',
    "data.csv": "time,reference_1,motor_angle_1\n"
    + "".join(f"{i * 0.004},{i * 0.001},{i * 0.00099}\n" for i in range(50)),
    "record.csv": "u,y\n"
    + "".join(f"{i * i % 7 - 3},{(i - 1) ** 2 % 7 - 3.1}\n" for i in range(200)),
    "log.csv": "timestamp, cmd_num, J1, J2\n0, 1, 10, 20\n0.004, 1, 10.5, 21\n",
    "individual.toml": "friction = [1.1, 1, 1, 0.9, 1, 1]\n",
    "gears.toml": f"{_GEARS}amplitude = 1.1e-5\nphase = 5.3\n",
}
BAD = {
    "empty.toml": "",
    "gears-huge.toml": f"{_GEARS}amplitude = 1e5\nphase = 1e5\n",
    "gears-nan.toml": f"{_GEARS}amplitude = nan\nphase = 0\n",
    "gears-version.toml": _GEARS.replace("1", "99", 1),
    "gears-robot.toml": _GEARS.replace("LARGE", "SMALL") + "amplitude = 0\nphase = 0\n",
    "empty.csv": "",
    "empty.json": "",
    "digits.toml": f"points = [[{'9' * 400}, 0], [1, 0], [0, 1]]\n",
    "huge.toml": "points = [[-1e308, -6], [1e308, -6], [10, 1e308]]\n",
    "nan.toml": "points = [[nan, -6], [inf, -6], [10, 6]]\n",
    "text.toml": "points = 'none'\ncorner = []\n",
    "torn.toml": "points = [[-10, -6], [10, -6",
    "list.json": "[1, 2, 3]",
    "deep.json": "[" * 100_000,
    "nan.json": '{"sample_time": NaN, "b": [0, Infinity], "a": [1, -0.5]}',
    "gain.json": '{"sample_time": 0.004, "b": [0.5], "a": [1]}',
    "huge.json": '{"sample_time": 0.004, "b": [0, 1e300], "a": [1, -1e300]}',
    "long.json": json.dumps({"sample_time": 0.004, "b": [0.0, 1.0] * 15_000, "a": [1.0, -0.5]}),
    "words.csv": "time,reference_1,motor_angle_1\na,b,c\n",
    "torn.csv": "time,reference_1,motor_angle_1\n0,1\n",
    "huge.csv": "k,time,reference_1,motor_angle_1\n9999999999,0,1e308,-1e308\n1.5,1,nan,inf\n",
    "header.csv": "time,reference_1,motor_angle_1\n",
    "torn.xml": "<mujoco><worldbody>",
    "other.xml": "<svg></svg>",
    "still.xml": '<mujoco><option timestep="0"/><worldbody><body><joint/><geom size="1"/></body>'
    "</worldbody></mujoco>",
    "box.xml": "<mujoco><worldbody><geom size='1'/></worldbody></mujoco>",
    "torn.dxf": "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n10\n",
    "friction.toml": "friction = [-1, nan, 1e308, 0, 1, 1]\n",
    "axes.toml": "friction = [1.1, 1]\ngear_error = [[1, 2], [3]]\n",
    "hinge.toml": "[[hidden]]\nbody = 'nowhere'\naxis = [0, 0, 0]\nstiffness = 2e6\ndamping = 1\n",
    "unknown.toml": "frictions = 1\n",
    "short.csv": "motor_angle_1,target_1_x,target_1_y,target_1_z\n0,1,1,1\n",
    "far.csv": "motor_angle_1,target_1_x,target_1_y,target_1_z\n" + "1e308,nan,-1e308,inf\n" * 50,
    "ä 漢字.toml": "points = 1",
}
BYTES = {
    "damaged.mat": b"MATLAB 5.0 MAT-file" + bytes(range(256)) * 4,
    "damaged.h5": b"\x89HDF\r\n\x1a\n" + bytes(200),
    "damaged.parquet": b"PAR1" + bytes(100) + b"PAR1",
    "damaged.mcap": b"\x89MCAP0\r\n" + bytes(200),
    "damaged.db3": b"SQLite format 3\0" + bytes(200),
    "damaged.dat": b"#BEGINCHANNELHEADER\n200,Zeit\n210,IMPLIZIT\n#ENDCHANNELHEADER\n",
    "latin.toml": "corner = 1 # \xe4".encode("latin-1"),
    "latin.csv": b"time,\xff\xfe\n1,2\n",
    "zeros.json": bytes(1000),
}
SPARSE = dict.fromkeys(
    ("large.toml", "large.json", "large.csv", "large.h5", "large.mcap"), 3000000000
)
"""Bytes of files that take no space on the disk."""


def make(folder: Path, run: Path) -> None:
    """Fill a folder. run: of a finished laser run, of which damaged copies are made."""
    for name, text in (GOOD | BAD).items():
        (folder / name).write_text(text, encoding="utf-8")
    for name, content in BYTES.items():
        (folder / name).write_bytes(content)
    for name, size in SPARSE.items():
        with open(folder / name, "wb") as file:
            file.truncate(size)
    os.mkfifo(folder / "fifo.toml")
    (folder / os.fsdecode(b"undecodable-\xff.toml")).write_text("points = 1")
    (folder / "folder").mkdir()
    (folder / "locked.toml").write_text("points = 1")
    _poses(folder / POSES)
    _motion(folder / MOTION)
    _matlab(folder)
    robot = Path(LARGE_ROBOT_XML).read_text(encoding="utf-8")
    for name, change in MODELS.items():
        (folder / name).write_text(robot.replace(*change, 1), encoding="utf-8")
    make_twins(folder)
    _copies(folder, run)


def _matlab(folder: Path) -> None:
    """Tables whose columns are no real numbers, or whose iterations are none."""
    from scipy.io import savemat

    n = 50
    columns = {"time": np.arange(n) * 0.004, "reference_1": np.ones(n), "motor_angle_1": np.ones(n)}
    savemat(folder / "complex.mat", columns | {"motor_angle_1": np.full(n, 1j)})
    for name, k in {"nan-k.mat": np.nan, "huge-k.mat": 1e300, "half-k.mat": 0.5}.items():
        savemat(folder / name, columns | {"k": np.full(n, k)})


def _poses(file: Path, n: int = 60) -> None:
    """A table of poses that `calibrate-arm --robot ur10` takes."""
    rng = np.random.default_rng(0)
    phi = rng.uniform(-2.0, 2.0, (n, 6))
    points = compile(CATALOGUE["ur10"].robot).pose(phi)[:, :3, 3] + rng.normal(0.0, 1e-4, (n, 3))
    names = [*(f"motor_angle_{i}" for i in range(1, 7)), *(f"target_1_{a}" for a in "xyz")]
    rows = np.hstack((phi, points))
    np.savetxt(file, rows, delimiter=",", header=",".join(names), comments="")


def _motion(folder: Path) -> None:
    """A recording that `gears --robot ur10` takes: encoders and a tracker, twelve seconds."""
    rng, time = np.random.default_rng(0), np.arange(0.0, 12.0, 0.01)
    phi = np.sin(np.outer(time, rng.uniform(0.5, 1.0, 6)) + rng.uniform(0.0, 6.0, 6))
    tool = compile(CATALOGUE["ur10"].robot).pose(phi)[:, :3, 3]
    tables = {"encoders": [f"motor_angle_{i}" for i in range(1, 7)]}
    tables["tracker"] = [f"target_{a}" for a in "xyz"]
    folder.mkdir()
    for (name, columns), values in zip(tables.items(), (phi, tool), strict=True):
        rows, header = np.column_stack((time, values)), ",".join(("time", *columns))
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header=header, comments="")


def _copies(folder: Path, run: Path) -> None:
    """Copies of a run that lack a file, or hold a wrong one."""
    summary = json.loads((run / "summary.json").read_text(encoding="utf-8"))
    config = summary["config"]
    changed = {
        "run-empty": {},
        "run-list": [],
        "run-foo": summary | {"config": config | {"experiment": "foo"}},
        "run-robot": summary | {"config": config | {"robot": "r2d2"}},
        "run-shape": summary | {"config": config | {"shape": 3}},
        "run-seedless": summary | {"config": {k: v for k, v in config.items() if k != "seed"}},
        "run-nameless": summary | {"config": {k: v for k, v in config.items() if k[0] != "e"}},
        "run-rows": summary | {"iterations": "none"},
        "run-format": summary | {"format": 99},
        "run-bare": summary,
    }
    for name, content in changed.items():
        (folder / name).mkdir()
        (folder / name / "summary.json").write_text(json.dumps(content), encoding="utf-8")
        if name != "run-bare":
            for file in ("signals.parquet", "robot.xml", "replay.rrd"):
                (folder / name / file).symlink_to(run / file)
    torn = folder / "run-torn"
    torn.mkdir()
    (torn / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    (torn / "signals.parquet").write_bytes((run / "signals.parquet").read_bytes()[:1000])
    (torn / "robot.xml").write_text("<mujoco>")


POSES = "poses.csv"
MOTION = "motion"
"""Folder of a recording in motion."""
MATLAB = ["complex.mat", "nan-k.mat", "huge-k.mat", "half-k.mat"]
MODELS = {
    "massless.xml": ('mass="', 'mass="-'),
    "massive.xml": ('mass="', 'mass="1e300'),
    "nan.xml": ('name="speed_limit" data="', 'name="speed_limit" data="nan '),
    "backwards.xml": ('name="gear_ratio" data="', 'name="gear_ratio" data="-'),
    "unstable.xml": ('stiffness="', 'stiffness="-'),
}
"""What is another text in a copy of the large robot, and which."""
NEVER = ["none.toml", "folder", "fifo.toml", "torn.toml", "damaged.mat", "damaged.h5", "torn.xml"]
"""Names of what is no file that any command reads."""
READ = [
    *GOOD,
    POSES,
    MOTION,
    *BAD,
    *BYTES,
    *MATLAB,
    *MODELS,
    *SPARSE,
    *NEVER,
    "undecodable-\udcff.toml",
]
"""Names of files that are given to be read, one of which does not exist."""
RUNS = [
    *("run", "run-empty", "run-list", "run-foo", "run-robot", "run-shape", "run-seedless"),
    *("run-nameless", "run-rows", "run-format", "run-bare", "run-torn", "folder", "none"),
]
"""Names of folders that are given as runs."""

Content = dict[str, Any]
TWIN_CHANGES: Mapping[str, Callable[[Content], Any]] = {
    "twin-list": lambda c: [c],
    "twin-empty": lambda c: {},
    "twin-format": lambda c: c | {"format": 99},
    "twin-robot": lambda c: c | {"robot": "irb1400"},
    "twin-other": lambda c: c | {"robot": ["large"]},
    "twin-file": lambda c: c | {"digest": "0" * 16},
    "twin-payload": lambda c: c | {"payload": -1e308},
    "twin-friction": lambda c: c | {"friction": [1e308] * 7},
    "twin-nan": lambda c: c | {"torque_residual": [float("nan")] * N_AXES},
    "twin-huge": lambda c: c | {"parameters": dict.fromkeys(c["parameters"], 1e308)},
    "twin-names": lambda c: c | {"parameters": {"a": 1.0}},
}
"""Changes of twin.json, by the name of the folder."""
BAD_TWINS = (*TWIN_CHANGES, "twin-torn", "twin-bare", "twin-covariance", "twin-pipe")
TWINS = ("twin", *BAD_TWINS)
"""Names of all folders."""


def make_twins(folder: Path) -> None:
    """Fill a folder: the twin is the design itself, as certain as a data sheet."""
    known = parameters_of(design_of("large", None))
    twin = Twin(
        robot="large",
        digest=robot_digest("large"),
        payload=None,
        sensor="tracker",
        theta=known.mean,
        covariance=np.diag(known.standard_deviation**2),
        held_out=np.full(2, 20e-6),
        torque_residual=np.full(N_AXES, 1e-2),
        names=("cut-1", "cut-2"),
    )
    for name in TWINS:
        (folder / name).mkdir()
        twin.save(folder / name)
    for name, change in TWIN_CHANGES.items():
        file = folder / name / "twin.json"
        file.write_text(json.dumps(change(json.loads(file.read_text()))), encoding="utf-8")
    (folder / "twin-torn" / "twin.json").write_text("{")
    (folder / "twin-bare" / "covariance.npy").unlink()
    np.save(folder / "twin-covariance" / "covariance.npy", -twin.covariance[:7])
    (folder / "twin-pipe" / "twin.json").unlink()
    (folder / "twin-pipe" / "twin.json").symlink_to("../fifo.toml")
