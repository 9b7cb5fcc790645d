"""Measure how many deliberate faults the tests notice.

    python -m tests.mutation run [--only TEXT] [--sample N] [--generic N] [--nearest] ...
    python -m tests.mutation page [--generic N]

`run` tries what has no result yet and ends with status 1 when a mutant survives without a reason;
`page` keeps the outcomes of generic mutants in `months/`, and writes docs/mutation.md.
"""

import argparse
import os
import random
from datetime import date

from .month import MONTHS, fates, updated, with_reasons, write
from .mutant import ROOT, Mutant, curated
from .page import page, score
from .session import Session, Trial

PAGE = ROOT / "docs/mutation.md"


def arguments() -> argparse.Namespace:
    """Options of the command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutation", description=__doc__)
    parser.add_argument("action", choices=("run", "page"))
    parser.add_argument("--only", default="", help="mutants with this text in file or name")
    parser.add_argument("--sample", type=int, help="number of mutants, drawn by --seed")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--generic", type=int, default=0, help="number of generic mutants")
    month = f"{date.today():%Y%m}"
    parser.add_argument("--month", default=month, help="YYYYMM, the seed of generic mutants")
    parser.add_argument("--nearest", action="store_true", help="leave out the wider tests")
    parser.add_argument("--checked", action="store_true", help="the tests are known to pass")
    parser.add_argument("--again", choices=("none", "survivors", "all"), default="none")
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    return parser.parse_args()


def main() -> int:
    """Run or write; 0 where every survivor has a reason."""
    options = arguments()
    os.chdir(ROOT)
    session, mutants = Session(), curated()
    generic = _generic(options.generic, options.month)
    if options.action == "page":
        results = session.results()
        if generic:
            write(options.month, updated(fates(options.month), generic, results))
        months = {file.stem: fates(file.stem) for file in MONTHS.glob("*.toml")}
        text = page(mutants, months, results, PAGE.read_text(encoding="utf-8"))
        PAGE.write_text(text, encoding="utf-8")
        return 0
    chosen = [m for m in (*mutants, *generic) if options.only in f"{m.file} {m.name}"]
    if options.sample is not None:
        random.Random(options.seed).shuffle(chosen)
        chosen = chosen[: options.sample]
    known = session.results()
    todo = [m for m in chosen if not m.equivalent and _pending(known.get(m.key), options.again)]
    how = {"workers": options.workers, "wider": not options.nearest, "checked": options.checked}
    session.run(todo, **how, report=_report)
    results = session.results()
    killed, tried = score(chosen, results)
    print(f"{killed} of {tried} noticed")
    lost = [m for m in chosen if m.key in results and not results[m.key].killed]
    return int(any(not (m.survives or m.equivalent) for m in lost))


def _generic(size: int, month: str) -> list[Mutant]:
    if not size:
        return []
    from .generic import sample

    return with_reasons(sample(size, int(month)), fates(month))


def _pending(known: Trial | None, again: str) -> bool:
    return known is None or again == "all" or (again == "survivors" and not known.killed)


def _report(mutant: Mutant, outcome: Trial) -> None:
    word = "noticed " if outcome.killed else "SURVIVES"
    print(f"{word} {mutant.file}: {mutant.name} [{outcome.by}]", flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
