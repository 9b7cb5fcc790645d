"""The contest of learning control is stable: two judged rounds rank its entries alike.

Each seed is ten tasks of both rounds, whose salts are the SHA-256 of a word each: they stand here,
so these rounds are judged by a claim and not by anybody's honesty. All settings of the entries were
chosen on the public tasks 1000 to 1005 of the joint. The first three tasks of a round claim-1 were
played while this was written, so it judges no longer. claim-2 was replaced in the same change: that
none of its tasks had been played is not on record, so it counts as seen. `contest-robot`
has fewer tasks on the other tracks. The cheat knows the public tasks 0 to 99, which are played too.
"""

import hashlib
from collections.abc import Iterator, Mapping

import numpy as np

from armside.sim.contest.entry_process import EntryProcess
from armside.sim.contest.judge import play
from armside.sim.contest.ranking import LEVEL, interval, significant
from armside.sim.contest.seal import Round
from armside.sim.contest.tracks import track

from ._engine import ROOT, Check, Claim, Row, Rows, Tally, all_hold, crossed

ENTRIES = ROOT / "docs" / "examples" / "contest"
TASKS = 10
"""Of each seed, in each round."""
ON_MOTORS = ("nothing", "thesis", "random_design", "random_search", "optuna_search")
ON_MODELS = ("norm_optimal", "knob_free", "time_reversal", "ai_mole", "dual_ilc")
CHEAT = "cheat"
JOINT = (*ON_MOTORS, *ON_MODELS, CHEAT)
ROBOT: Mapping[str, tuple[str, ...]] = {
    "motor": (*ON_MOTORS, *ON_MODELS, "ppo"),
    "imu": ("nothing", "thesis", "estimate"),
    "tracker": ("nothing", "thesis", "tracker"),
    "first": ("nothing", "twin"),
    "drift": ("nothing", "thesis", "knob_free"),
    "part": ("nothing", "thesis", "knob_free"),
}
WITHIN, UNCHANGED = 0.9, 1.0
"""Part of the entries whose scores of both rounds differ by less than the 95 % interval of such a
difference, which is wider than that of one round; and of the significantly different pairs that
keep their order."""


def _round(name: str) -> Round:
    salt = hashlib.sha256(f"claim {name}".encode()).digest()
    return Round(name, hashlib.sha256(salt).hexdigest(), salt)


ROUNDS = {"public": Round(), "1": _round("claim-3"), "2": _round("claim-4")}


def run(case: tuple[int, tuple[str, str]], tally: Tally) -> Iterator[Row]:
    seed, (name, entry) = case
    of, source = track(name), (ENTRIES / f"{entry}.py").read_text(encoding="utf-8")
    count = TASKS if name == "joint" else 1
    with EntryProcess() as process:
        for which, round in ROUNDS.items():
            if which == "public" and entry not in (CHEAT, "thesis"):
                continue
            for index in range(seed * count, (seed + 1) * count):
                row = play(source, of.draw(round, index), of, process)
                tally.add(())
                yield {
                    **{"track": name, "entry": entry, "round": which, "task": index},
                    **{"left": row["left"], "harm": row["harm"], "lost": bool(row["reason"])},
                    **{"seconds": row["seconds"], "runs": row["runs"], "_why": row["reason"]},
                }


def shown(rows: Rows) -> Iterator[Row]:
    for name, of in rows.by("track").items():
        for entry, own in of.by("entry").items():
            for which, one in own.by("round").items():
                left = np.log(one["left"])
                low, high = interval(left)
                yield {
                    **{"track": name, "entry": entry, "round": which, "tasks": len(one)},
                    "left": float(np.exp(left.mean())),
                    "95 % interval": f"{low:.3f} to {high:.3f}",
                    "harmed": float(one["harm"].mean()),
                    "worst": float(one["left"].max()),
                    "lost": int(one["lost"].sum()),
                    "runs": float(one["runs"].mean()),
                    "seconds a task": float(one["seconds"].mean()),
                }


def logs(rows: Rows, which: str) -> dict[str, np.ndarray]:
    """Logarithm of what each entry leaves, by task."""
    found = {}
    for entry, own in rows.by("entry").items():
        one = own.by("round").get(which)
        if one is not None:
            found[entry] = np.log(one["left"][np.argsort(one["task"])])
    return found


def checks(rows: Rows) -> Iterator[Check]:
    inside, kept, pairs = list[bool](), list[bool](), 0
    for _, of in rows.by("track").items():
        first, second = logs(of, "1"), logs(of, "2")
        for entry in first:
            inside.append(overlaps(first[entry], second[entry]))
        for (better, worse), p in significant(first).items():
            if p < LEVEL:
                pairs += 1
                kept.append(bool(second[better].mean() < second[worse].mean()))
    words = "scores of both rounds differ by less than the interval of a difference"
    words += f" ({sum(inside)} of {len(inside)})"
    yield Check("", words, "", float(np.mean(inside)), low=WITHIN)
    if kept:
        words = f"pairs that differ significantly and keep their order ({sum(kept)} of {pairs})"
        yield Check("", words, "", float(np.mean(kept)), low=UNCHANGED)
    yield from cheat_checks(rows)


def overlaps(first: np.ndarray, second: np.ndarray) -> bool:
    """Two geometric means differ by less than the 95 % interval of the difference of two means that
    are as spread as these, from logarithms (n,)."""
    both = first.var(ddof=1) / len(first) + second.var(ddof=1) / len(second)
    return bool(abs(first.mean() - second.mean()) <= 1.96 * np.sqrt(both) + 1e-3)


def cheat_checks(rows: Rows) -> Iterator[Check]:
    """On the joint: by how much the cheat is better than the thesis's design, in public and not."""
    of = rows.by("track").get("joint")
    if of is None:
        return
    gain = {w: logs(of, w)[CHEAT] - logs(of, w)["thesis"] for w in ROUNDS}
    ends = {which: interval(each) for which, each in gain.items()}
    said = {which: f"{low:.2f} to {high:.2f}" for which, (low, high) in ends.items()}
    words = "the cheat leaves less than the thesis's design on public tasks"
    yield all_hold(
        f"{words} (95 % interval of the ratio {said['public']})", ends["public"][1] < 1.0
    )
    for which in ("1", "2"):
        words = f"it gains nothing in judged round {which} ({said[which]})"
        yield all_hold(words, ends[which][1] >= 1.0 - 1e-9)


def _claim(title: str, seeds: int, entries: Mapping[str, tuple[str, ...]]) -> Claim:
    played = [(name, entry) for name, own in entries.items() for entry in own]
    return Claim(
        title=title, seeds=seeds, run=run, checks=checks, shown=shown, cases=crossed(played)
    )


CLAIM = _claim("Contest, joint: two judged rounds of {n} times ten tasks", 10, {"joint": JOINT})
CLAIM_ROBOT = _claim("Contest, robot: two judged rounds of {n} tasks", 12, ROBOT)
