"""Error of the estimate by what it uses: the table of a claim, drawn."""

from pathlib import Path

from armside.sim.evaluation.check import Table

from ..claims.estimation_controls import draw as bars
from ..pages._engine import claim_page, table

LINE = ""
CLAIM = "estimation-controls"


def draw(_run: Path, file: Path) -> list[list[float | str]]:
    rows = table(claim_page(CLAIM))
    bars(file, Table("", [""] * len(rows[0]), rows))
    return rows
