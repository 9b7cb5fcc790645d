"""`--forecast`: said before the first run, in the summary, and what is refused because of it."""

import json

import numpy as np
import pytest

from armside.sim.laser import forecast as module
from armside.sim.laser.forecast import Forecast, Left

QUICK = "laser --radius 3 --speed 60 --iterations 1 --forecast"


@pytest.fixture
def bad(monkeypatch):
    """Motors leave 150 %, the tracker 3 %."""
    left = [
        Left(
            measure=name,
            updates=5,
            median=share,
            low=0.5 * share,
            high=2.0 * share,
            worse=worse,
            calibrated=name != "tracker",
        )
        for name, share, worse in (("motor", 1.5, 0.8), ("tracker", 0.03, 0.0))
    ]
    found = Forecast(uncorrected=2e-4, robots=8, left=tuple(left), assumed=("of fish",))
    monkeypatch.setattr(module, "forecast", lambda *_, **__: found)


@pytest.mark.usefixtures("bad")
def test_motors_are_refused_where_most_robots_would_end_worse(armside):
    status, _, err = armside(QUICK)
    assert status == 2
    assert err.startswith("armside: learning from motor is forecast to leave 150 % (75 to 300)")
    assert "80 % of robots end worse" in err
    assert "tracker 3 %; choose one of them, or ask for --measure motor by name" in err
    assert err.count("\n") == 1


@pytest.mark.usefixtures("bad")
def test_motors_by_name_are_learned_from_with_a_note(armside, tmp_path):
    status, out, _ = armside(f"{QUICK} --measure motor --out {tmp_path / 'a'}")
    summary = json.loads((tmp_path / "a" / "summary.json").read_text())
    assert status == 0
    assert "Forecast of the tool RMS, per cent of 200 µm" in out
    assert summary["forecast"]["uncorrected"] == 2e-4
    assert np.isclose(summary["forecast"]["left"][0]["median"], 1.5)
    assert "tracker (not calibrated)" in out
    assert "motor (not" not in out
    texts = [note["text"] for note in summary["notes"] if note["cause"] == "forecast"]
    assert texts[0] == "forecast: of fish"
    assert texts[1].startswith("learning from motor is forecast to leave 150 %")


@pytest.mark.parametrize(
    ("line", "text"),
    [
        (f"{QUICK} --from {{folder}}", "leave out --from"),
        (f"{QUICK} --twin {{folder}}", "leave out --twin"),
        ("cut examples.toml --plan-only --forecast", "leave out --plan-only"),
        ("cut examples.toml --as-program krl --forecast", "leave out --as-program"),
    ],
)
@pytest.mark.usefixtures("bad")
def test_a_forecast_of_what_is_no_first_run_is_refused(armside, tmp_path, line, text):
    drawing = "corner = 3.0\npoints = [[0, 0], [30, 0], [30, 20]]\n"
    (tmp_path / "examples.toml").write_text(drawing)
    if "--from" in line:
        assert (
            armside(f"laser --radius 3 --speed 60 --iterations 0 --out {tmp_path / 'b'}").status
            == 0
        )
    status, _, err = armside(line.format(folder=tmp_path / "b"))
    assert status == 2
    assert text in err
