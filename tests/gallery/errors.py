"""Errors of the run over its iterations."""

import shutil
from pathlib import Path


def draw(run: Path, file: Path) -> None:
    shutil.copy(run / "errors.png", file)
