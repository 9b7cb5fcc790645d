"""`python -m tests.claims [NAME ...]`: claims over all their seeds, and their pages in the docs.

`make claims` calls it. A claim that is stopped goes on where it was.
"""

import argparse
import json
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from armside.sim.records.atomic import write_whole
from armside.sim.records.summary import summary

from .. import evidence
from ..pages._engine import claim_file, code
from ._engine import Claim, judged
from ._pages import command, index, page

KEPT = Path("runs") / "claims"


def main(words: Sequence[str] | None = None) -> int:
    """Judge the claims, print and write their pages, and return 1 where a statement fails."""
    parser = argparse.ArgumentParser(prog="python -m tests.claims", description=__doc__)
    parser.add_argument("names", nargs="*", help="claims [default: all]")
    parser.add_argument("--seeds", type=int, default=0, help="number [default: the full instance]")
    parser.add_argument("--seed", type=int, default=0, help="the first")
    parser.add_argument("--docs", type=Path, default=Path("docs") / "claims", help="of the pages")
    parser.add_argument("--json", action="store_true", help="print the tables as JSON")
    asked = parser.parse_args(words)
    if asked.seeds < 0 or asked.seed < 0:
        parser.error("--seeds and --seed must be >= 0")
    failed = 0
    for name in evidence.chosen("claims", asked.names):
        failed += _judge(name, asked.seeds, asked.seed, asked.docs, asked.json)
    write_whole(asked.docs / "index.md", index(asked.docs))
    return int(failed > 0)


def _judge(name: str, n_seeds: int, first: int, docs: Path, as_json: bool) -> int:
    """Number of statements of a claim that fail."""
    claim: Claim = evidence.claim(name)
    seeds, kept = range(first, first + (n_seeds or claim.seeds)), KEPT / name
    bar, step = evidence.progress(name, len(list(claim.cases(seeds))))
    with bar:
        table = judged(claim, seeds, processes=None, kept=kept, step=step)
    made_by = command(name, len(seeds), first)
    verdicts = [(check.statement, check.holds) for check in table.verdicts]
    outcome = summary("claims", {"name": name}, {"seeds": len(seeds), "seed": first}, table={
        "title": table.title, "columns": table.columns, "rows": table.rows, "verdicts": verdicts,
    }, notes=table.notes)  # fmt: skip
    versions = outcome["config"]["versions"] | {"code": code([claim_file(name)])}
    text = page(table, made_by, versions)
    docs.mkdir(parents=True, exist_ok=True)
    write_whole(docs / f"{name}.md", text)
    if claim.figure is not None:
        claim.figure(docs / f"{name}.png", table)
    shutil.rmtree(kept, ignore_errors=True)
    notes = "".join(f"Note: {note.line}\n" for note in table.notes)
    print(json.dumps(outcome) if as_json else f"{text}{notes}")
    return sum(not check.holds for check in table.verdicts)


if __name__ == "__main__":
    sys.exit(main())
