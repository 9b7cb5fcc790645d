"""Figures are results: what a run draws is what its summary says, in the unit beside it."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from armside.scripts import cli

FLANGE = Path(__file__).parents[2] / "docs" / "examples" / "flange.dxf"
LINES = {
    "laser": "laser --iterations 1",
    "first": "laser --iterations 0",
    "compare": "compare --poses p1 --speeds 40 --iterations 1",
    "cut": f"cut {FLANGE} --iterations 1",
}
UNITS = {"µm": 1e6, "mm": 1e3, "normalised": 1.0}
"""How many of each are one of the summary's, which is in SI."""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """By name of a line its summary, its figures, not written, and its folder; each made once."""
    found = {}

    def run(name):
        if name not in found:
            out, figures = tmp_path_factory.mktemp("made") / name, {}
            with pytest.MonkeyPatch.context() as patch:
                keep = lambda figure, file, **_: figures.update({Path(file).name: figure})  # noqa: E731
                patch.setattr(Figure, "savefig", keep)
                assert cli.main([*LINES[name].split(), "--quiet", "--out", str(out)]) == 0
            found[name] = json.loads((out / "summary.json").read_text()), figures, out
        return found[name]

    return run


def y(axes):
    """Values of all lines with a marker or a name, in their order."""
    return [line.get_ydata() for line in axes.lines if not line.get_label().startswith("_")]


def rows(name):
    return lambda summary: [row[name] for row in summary["iterations"]]


def magnified(axes):
    """Largest distance of the drawn path from the reference, by the length of the bar for 100."""
    reference, path, bar = (np.asarray(line.get_xydata()) for line in axes.lines)
    (said,) = re.findall(r"bar: deviation of (\d+) µm", text(axes.figure))
    away = path[:, None] - reference
    step = np.diff(reference, axis=0)
    t = np.clip((away[:, :-1] * step).sum(2) / (step**2).sum(1), 0.0, 1.0)
    off = np.linalg.norm(away[:, :-1] - t[..., None] * step, axis=2).min(1)
    return float(said) / np.ptp(bar[:, 0]) * off.max()


def text(figure):
    return " ".join(t.get_text() for legend in figure.legends for t in legend.get_texts())


def title(axes):
    return axes.get_title() or axes.get_title(loc="left")


def widest(axes):
    """Largest width between the edges of the kerf."""
    hole, piece = (patch.get_xy() for patch in axes.patches)
    return np.linalg.norm(hole - piece, axis=1).max()


def numbers(axes):
    """Numbers of a panel's title in µm."""
    return [float(n) for n in re.findall(r"([\d.]+) µm", title(axes))]


def ranges(axes):
    return [np.ptp(values) for values in y(axes)]


def holes(summary):
    return summary["kerf"]["hole_roundness_true"]


def tool(k):
    return lambda summary: [rows(name)(summary)[k] for name in ("arm_rms", "arm_maxdev")]


def motors(summary):
    return np.transpose(rows("motor_inf_normalised")(summary))


# Each: line, figure, its panel, where its unit is written, what is drawn, what the summary has.
# Numbers in titles are whole micrometres; a path of 361 sides is within 0.2 um of its circle.
Y = {"rtol": 1e-12}
WHOLE = {"rtol": 0.0, "atol": 0.5}
SHOWN = [
    ("laser", "errors.png", 0, "label", y, motors, Y),
    ("laser", "errors.png", 1, "label", lambda a: y(a)[0], rows("arm_maxdev"), Y),
    ("laser", "errors.png", 1, "label", lambda a: y(a)[1], rows("arm_rms"), Y),
    ("laser", "circles.png", 1, "title", numbers, tool(1), WHOLE),
    ("laser", "circles.png", 0, "legend", magnified, lambda s: rows("arm_maxdev")(s)[0], WHOLE),
    ("laser", "circles.png", 1, "legend", magnified, lambda s: rows("arm_maxdev")(s)[1], WHOLE),
    ("laser", "kerf.png", 1, "title", numbers, lambda s: holes(s)[1:], WHOLE),
    ("laser", "kerf.png", 2, "label", ranges, holes, Y),
    ("first", "kerf.png", 1, "label", ranges, holes, Y),
    (
        "compare",
        "compare.png",
        0,
        "label",
        y,
        lambda s: [r["arm_rms"] for r in s["comparisons"]],
        Y,
    ),
    ("laser", "kerf.png", 0, "x", widest, lambda s: s["kerf"]["widest_true"][0], Y),
    ("cut", "part.png", 0, "title", numbers, lambda s: rows("arm_rms")(s)[:1], WHOLE),
    ("cut", "part.png", 1, "title", numbers, lambda s: rows("arm_rms")(s)[1:], WHOLE),
    ("cut", "errors.png", 1, "label", lambda a: y(a)[1], rows("arm_rms"), Y),
]


@pytest.mark.parametrize("case", SHOWN, ids=lambda c: f"{c[0]}-{c[1]}-{c[2]}-{c[3]}")
def test_a_figure_draws_what_the_summary_has_in_the_unit_beside_it(made, case):
    line, file, panel, where, drawn, expected, within = case
    summary, figures, _ = made(line)
    axes = figures[file].axes[panel]
    words = axes.get_xlabel(), axes.get_ylabel(), title(axes), text(axes.figure)
    beside = dict(zip(("x", "label", "title", "legend"), words, strict=True))[where]
    (unit,) = {name for name in UNITS if name in beside}
    np.testing.assert_allclose(drawn(axes), UNITS[unit] * np.array(expected(summary)), **within)


def test_colours_of_a_part_are_its_deviations_on_a_scale_of_each_run(made):
    """The tool's path is registered within each contour; the largest of all ends the scale."""
    summary, figures, _ = made("cut")
    panels = [axes for axes in figures["part.png"].axes if axes.get_xlabel()]
    bars = [axes for axes in figures["part.png"].axes if not axes.get_xlabel()]
    assert len(panels) == len(bars) == 2
    for k, (axes, bar) in enumerate(zip(panels, bars, strict=True)):
        assert "[µm]" in bar.get_ylabel()
        assert f"k = {k}" in bar.get_ylabel()
        values = [lines.get_array() for lines in axes.collections]
        worst = 1e6 * np.array([c["iterations"][k]["arm_maxdev"] for c in summary["contours"]])
        np.testing.assert_allclose([np.abs(v).max() for v in values], worst, rtol=0.02)
        limits = {lines.get_clim() for lines in axes.collections}
        assert limits == {(-max(limits)[1], max(limits)[1])}
        assert max(limits)[1] == pytest.approx(worst.max(), rel=0.02)
        assert not axes.lines  # nothing magnified, no rapid move


@pytest.mark.parametrize("line", ["laser", "first"])
def test_axes_of_a_run_have_names_units_and_round_ticks(made, line):
    _, figures, _ = made(line)
    for file, figure in figures.items():
        assert all(axes.get_xlabel() for axes in figure.axes[-1:]), file
        for axes in figure.axes:
            figure.canvas.draw()
            ticks = [label.get_text() for label in axes.get_xticklabels() if label.get_text()]
            assert len(set(ticks)) == len(ticks), file
            assert "−0" not in ticks
            places = axes.get_yticks() if axes.get_yscale() == "linear" else []
            for step in np.unique(np.diff(places).round(9)):
                mantissa = step / 10.0 ** np.floor(np.log10(step))
                assert round(mantissa, 6) in (1, 2, 2.5, 5, 10), (file, step)
        assert figure.get_suptitle() or all(map(title, figure.axes)), file


def test_a_single_run_leaves_no_blank_sheet(made):
    """Its sheet and its edge share the width of kerf.png; circles.png fits its title."""
    _, figures, _ = made("first")
    boxes = [axes.get_position() for axes in figures["kerf.png"].axes]
    assert len(boxes) == 2
    assert boxes[0].x1 < boxes[1].x0
    assert max(box.x1 for box in boxes) > 0.95
    figure = figures["circles.png"]
    figure.canvas.draw()
    for shown in (figure._suptitle, *figure.legends):
        box = shown.get_window_extent()
        assert 0.0 < box.x0 < box.x1 < figure.bbox.x1


def test_a_comparison_is_named_in_plain_words(made):
    _, figures, _ = made("compare")
    figure = figures["compare.png"]
    assert "deviation" in figure.get_suptitle()
    assert text(figure) == "motors estimate laser tracker ground truth"
    assert figure.axes[0].get_ylabel() == "tool deviation, RMS [µm]"


def test_a_plan_shows_what_is_drawn_over_what_is_cut(made):
    top = made("cut")[1]["plan.png"].axes[0]
    drawn = [line for line in top.lines if line.get_label() == "drawn"]
    assert len(drawn) == len(made("cut")[0]["contours"])
    assert min(line.get_zorder() for line in drawn) > max(c.get_zorder() for c in top.collections)
    assert "thin black: drawn" in title(top)


def sent(file, store=None):
    """Batches of a replay, or of its blueprint, by entity."""
    from rerun.chunk import RrdReader

    reader = RrdReader(file)
    stream = reader.stream(store=reader.blueprints()[0]) if store else reader.stream()
    for chunk in stream.to_chunks():
        batch = chunk.to_record_batch()
        names = [name for name in batch.schema.names if ":" in name]
        yield chunk.entity_path, {n.split(":")[1]: batch.column(n)[0].as_py() for n in names}


def test_the_replay_of_a_part_colours_its_contours_and_draws_rapid_moves_thin(made):
    summary, _, out = made("cut")
    entities = list(sent(out / "replay.rrd"))
    tools = [own for entity, own in entities if entity == "/plane/tool"]
    scales = [own["labels"][0] for entity, own in entities if entity == "/plane/scale"]
    cut, rapid = (dict(entities)[f"/plane/{name}"] for name in ("programmed", "rapid"))
    n = len(summary["contours"])
    assert len(cut["strips"]) == n  # one line each, none from contour to contour
    assert len(rapid["strips"]) == n + 1
    assert abs(rapid["radii"][0]) < abs(tools[0]["radii"][0])
    points = np.concatenate([np.array(strip) for strip in cut["strips"]])
    for k, (tool, scale, row) in enumerate(zip(tools, scales, summary["iterations"], strict=True)):
        worst = float(re.search(r"red (\d+) µm", scale)[1])
        assert f"k = {k}: blue −{worst:.0f} µm" in scale
        # The tool as its mean offset leaves it, along the whole part; the summary's is of each.
        assert 0.5 < 1e-6 * worst / row["arm_maxdev_true"] < 2.0
        pieces = np.concatenate([np.array(strip) for strip in tool["strips"]])
        off = np.hypot(*(pieces[::7, None] - points).T).min(0).max()
        assert off < 1.1e-3 * worst + 0.2  # [mm], to scale; points are 0.16 mm apart
        rgb = np.array([[c >> 24 & 255, c >> 16 & 255, c >> 8 & 255] for c in tool["colors"]])
        assert len(rgb) == len(tool["strips"])
        assert np.ptp(rgb, axis=1).max() > 150  # the last run is not all grey
    blueprint = [own for _, own in sent(out / "replay.rrd", "blueprint")]
    ends = [own["view_range"] for own in blueprint if "view_range" in own]
    assert ends
    assert all(range["start"] == 0 < range["end"] for (range,) in ends)
