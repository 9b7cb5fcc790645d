"""The task that the option --plant names."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from armside.ilc.workbench.words import Words, unknown_name
from armside.sim.records.files import check_file

from ..shell.effort import Effort, refuse_absurd
from ..shell.errors import InputError
from .controllers import PROTOCOLS, controller_task, laser_values
from .options import LearnCfg

if TYPE_CHECKING:
    from armside.ilc.workbench.task import Task

ROBOTS = ("large", "irb1400")
FILES = ("FILE.toml", "FILE.json", "FILE.mat", "file.py:Name", "a folder")
NAMES = ("two-mass", *ROBOTS, *PROTOCOLS, *FILES)
LARGEST_MODEL = 1_000_000
"""[bytes], of a model's file."""
SECONDS_LINEAR, SECONDS_ROBOT = 3e-6, 1e-4
"""[s] for each number of a run's record, the law included, rounded up."""


def named_task(cfg: LearnCfg, seed: int, followed: Path | None = None) -> "Task":
    """Everything before the first run. followed: file with the reference of an earlier run that is
    continued on a controller. Raises ValueError or OwnCodeError."""
    from armside.ilc.models.file import read_model
    from armside.ilc.workbench import plants

    words = Words.parse(cfg.plant)
    model = None if cfg.model is None else read_model(check_file(cfg.model, LARGEST_MODEL))
    record = plants.Record(
        reference=cfg.reference or "",
        n_samples=cfg.samples,
        sample_time=cfg.sample_time,
        model=model,
    )
    if cfg.beyond and words.name not in PROTOCOLS:
        raise ValueError(f"beyond is of a controller, {' or '.join(PROTOCOLS)}: leave it out")
    robot = words.name in ROBOTS or words.name.endswith(".toml")
    if words.file:
        task = plants.own_plant(words, record, seed)
    elif words.name == "two-mass":
        task = plants.joint(words, record)
    elif robot:
        task = _robot(words, cfg, record, seed)
    elif words.name in PROTOCOLS:
        task = controller_task(words, record, followed, cfg.beyond)
    elif "\0" in cfg.plant or not cfg.plant or not Path(cfg.plant).exists():
        raise ValueError(unknown_name("plant", cfg.plant, NAMES))
    else:
        task = plants.model_task(check_file(Path(cfg.plant), LARGEST_MODEL), record)
    runs = len(cfg.laws) * len(cfg.noise) * cfg.repeats * (cfg.iterations + 1)
    each = SECONDS_ROBOT if robot or words.name in PROTOCOLS else SECONDS_LINEAR
    what = f"{runs} runs of {task.reference.size} numbers"
    refuse_absurd(what, Effort(seconds=runs * task.reference.size * each))
    return task


def is_folder(cfg: LearnCfg) -> bool:
    """The plant is run by hand, files exchanged in a folder. A name of a plant is not a folder's,
    which may be of results that were kept under that name."""
    if cfg.plant in NAMES:
        return False
    try:
        return bool(cfg.plant) and Path(cfg.plant).is_dir()
    except (OSError, ValueError):
        return False


def _robot(words: Words, cfg: LearnCfg, record: Any, seed: int) -> "Task":
    from armside.sim.laser.learning_task import learning_task

    from ..cutting.options import LaserCfg
    from ..cutting.specification import cut

    if cfg.reference or cfg.sample_time is not None:
        raise ValueError("a robot's reference is its cut: leave --reference and --sample-time out")
    asked = LaserCfg(robot=words.name, **laser_values(words), iterations=cfg.iterations)
    return learning_task(cut(asked), seed=seed, name=words.text, model=record.model)


CONTOUR = ("shape", "radius", "size", "width", "corner", "contour")
PLACE = ("pose", "plane", "position", "quaternion")
"""Of one robot; another robot has poses of its own."""


def refuse_other_path(before: str, now: str) -> None:
    """Raise InputError where two plants, such as large:radius=2,speed=60, follow other paths."""
    from ..cutting.options import LaserCfg

    old, new = (Words.parse(text) for text in (before, now))
    known, asked = (LaserCfg(robot=words.name, **laser_values(words)) for words in (old, new))
    names = (*CONTOUR, *(PLACE if old.name == new.name else ()))
    for name in names:
        if getattr(known, name) != getattr(asked, name):
            other = f"{now} has another {name}, and a correction belongs to its path"
            raise InputError(f"{before} cannot be started from: {other}")
