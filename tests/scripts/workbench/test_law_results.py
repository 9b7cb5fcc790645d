"""Notes on laws that make the tool worse."""

from types import SimpleNamespace

from armside.scripts.workbench.law_results import of_the_tool
from armside.sim.notes import GROWTH


def run(law, *tool):
    return SimpleNamespace(law=law, measures=[{"arm_rms": rms} for rms in tool])


def test_a_tool_that_got_worse_by_more_than_a_twentieth_is_noted_in_micrometres():
    runs = [run("a", 1e-4, 1.049e-4), run("b", 1e-4, 2e-4), run("c", 1e-4, 3e-5)]
    assert GROWTH == 1.05
    assert of_the_tool(runs) == ["1 of 3 runs made the tool worse: RMS 100 to 200 um with b"]
    assert of_the_tool([runs[0], runs[2]]) == []
