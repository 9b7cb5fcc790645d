"""Commands that are done, in this process."""

import json
from pathlib import Path
from typing import Any

from armside.scripts.cli import main


def ran(out: Path, *words: Any) -> dict[str, Any]:
    """Summary of a command, in words or in one line, whose results are in a folder."""
    line = [word for each in words for word in str(each).split()]
    assert main([*line, "--quiet", "--out", str(out)]) == 0
    return json.loads((out / "summary.json").read_text(encoding="utf-8"))
