"""The lines of docs/choose-a-law.md that compare every law: on chapter 8's joint and on a robot."""

import ast
import json
import shlex
from pathlib import Path

import pytest

from armside.ilc.workbench.laws import LAWS
from armside.scripts.cli import main

pytestmark = pytest.mark.usefixtures("unrendered")

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "choose-a-law.md").read_text(encoding="utf-8").replace("\\\n", " ")
COMPOSED = ROOT / "docs" / "examples" / "composed_laws.py"


def line_of(plant: str) -> list[str]:
    """Words of the page's line for a plant, without the program's name."""
    (line,) = (each for each in PAGE.splitlines() if f"armside learn --plant {plant}" in each)
    return shlex.split(line)[1:]


def compared(plant: str, place: Path, monkeypatch: pytest.MonkeyPatch) -> list[dict]:
    """Summary of each law of the page's line."""
    monkeypatch.chdir(ROOT)
    assert main([*line_of(plant), "--quiet", "--out", str(place / "a")]) == 0
    return json.loads((place / "a" / "summary.json").read_text(encoding="utf-8"))["laws"]


@pytest.mark.parametrize("plant", ["two-mass", "large"])
def test_a_line_of_the_page_names_every_law(plant):
    words = line_of(plant)
    named = {word.removeprefix("docs/examples/") for word in words[words.index("--laws") + 1 :]}
    classes = ast.parse(COMPOSED.read_text(encoding="utf-8")).body
    own = {f"composed_laws.py:{each.name}" for each in classes if isinstance(each, ast.ClassDef)}
    assert own
    assert {name if name in own else name.split(":")[0] for name in named} == own | set(LAWS)


def test_every_law_leaves_on_the_joint_what_is_predicted_and_less_than_at_first(
    tmp_path, monkeypatch
):
    for law in compared("two-mass", tmp_path, monkeypatch):
        assert law["predicted"]["error_two"] == pytest.approx(law["error_two"], rel=1e-6), law
        assert law["error_two"][-1] < law["error_two"][0], law["law"]


def test_every_law_is_predicted_on_a_robot_up_to_friction(tmp_path, monkeypatch):
    """Of the error of k = 0 less than a quarter parts the first update from its prediction."""
    for law in compared("large", tmp_path, monkeypatch):
        before, after = law["error_two"]
        assert not law["diverged"]
        assert law["predicted"]["error_two"][-1] == pytest.approx(after, abs=0.25 * before), law
