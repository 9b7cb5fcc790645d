"""SVG is cut where a viewer draws it: uses, symbols, viewports, units and styles resolved."""

from time import process_time

import numpy as np
import pytest

from armside.sim.part.drawing import Reading, Unit
from armside.sim.part.svg import read_svg

HEAD = (
    '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
    'width="120mm" height="80mm" viewBox="0 0 120 80" fill="none" stroke="black">'
)
DOT = '<circle id="c" cx="30" cy="30" r="5"/>'


def read(folder, body, head=HEAD, **reading):
    (folder / "a.svg").write_text(f"{head}{body}</svg>")
    return read_svg(folder / "a.svg", Reading(**reading))


def boxes(drawing):
    """Left, top, right and bottom of each contour [mm], y down, sorted."""
    found = []
    for entity in drawing.entities:
        (x, y), (u, v) = 1e3 * np.array(
            [f(entity.chain.polygon(), axis=0) for f in (np.min, np.max)]
        )
        found.append((x, -v, u, -y))
    return sorted(found)


def around(x, y, rx, ry=None):
    ry = rx if ry is None else ry
    return (x - rx, y - ry, x + rx, y + ry)


PLACED = {
    "a symbol at the place of its use": (
        f'<symbol id="s">{DOT}</symbol><use href="#s" x="40" y="20"/>',
        [around(70, 50, 5)],
    ),
    "a use of a shape in defs with its own style": (
        '<defs><circle id="c" cx="30" cy="30" r="5"/></defs><use href="#c" style="stroke:red"/>',
        [around(30, 30, 5)],
    ),
    "a use of a shape in defs with the style of its parent": (
        f'<defs>{DOT}</defs><g stroke="red"><use xlink:href="#c" x="10"/></g>',
        [around(40, 30, 5)],
    ),
    "a use of a use of a group": (
        f'<defs><g id="g" transform="scale(2)">{DOT}</g>'
        '<use id="u" href="#g" y="-20"/></defs><use href="#u" x="10" transform="translate(0 5)"/>',
        [around(70, 45, 10)],
    ),
    "a symbol fitted into the size of its use": (
        '<symbol id="s" viewBox="0 0 10 20"><circle cx="5" cy="10" r="5"/></symbol>'
        '<use href="#s" x="20" y="10" width="40" height="40"/>',
        [around(40, 30, 10)],
    ),
    "a nested svg that is stretched": (
        '<svg x="10" y="10" width="40" height="20" viewBox="0 0 10 10" preserveAspectRatio="none">'
        '<circle cx="5" cy="5" r="2"/></svg>',
        [around(30, 20, 8, 4)],
    ),
    "a circle that is stretched": (
        '<circle cx="20" cy="20" r="5" transform="scale(2,1.6)"/>',
        [around(40, 32, 10, 8)],
    ),
    "per cent of the viewport": (
        '<rect x="25%" y="25%" width="50%" height="50%"/>',
        [around(60, 40, 30, 20)],
    ),
    "a switch shows one of its children": (
        f'<switch><foreignObject requiredExtensions="x"/>{DOT}<circle r="9"/></switch>',
        [around(30, 30, 5)],
    ),
    "a smooth curve after one of another kind starts straight": (
        '<path d="M10 10Q20 0 30 10S30 20 20 20z"/>',
        [(10, 5, 30, 20)],
    ),
    "an arc without radius is a line": (
        '<path d="M10 10H20A0 5 0 0 0 20 20H10z"/>',
        [around(15, 15, 5)],
    ),
}


@pytest.mark.parametrize("case", PLACED)
def test_a_contour_lies_where_a_viewer_draws_it(case, tmp_path):
    body, wanted = PLACED[case]
    np.testing.assert_allclose(boxes(read(tmp_path, body)), wanted, atol=2e-3)


def test_a_circle_of_inches_and_millimetres_has_them_on_the_sheet(tmp_path):
    head = HEAD.replace('viewBox="0 0 120 80"', "")
    drawing = read(tmp_path, '<circle cx="1in" cy="2cm" r="5mm"/>', head)
    np.testing.assert_allclose(boxes(drawing), [around(25.4, 20, 5)], atol=2e-3)


def test_a_skewed_circle_is_the_ellipse_of_its_matrix(tmp_path):
    (entity,) = read(
        tmp_path, '<circle r="5" transform="translate(60 40) skewX(60) scale(1,3)"/>'
    ).entities
    matrix = np.array([[1.0, np.tan(np.pi / 3)], [0.0, 1.0]]) @ np.diag([1.0, 3.0])
    points = 1e3 * entity.chain.polygon() * [1, -1] - [60.0, 40.0]
    radius = np.linalg.norm(np.linalg.solve(matrix, points.T), axis=0)
    np.testing.assert_allclose(radius, 5.0, atol=5e-3)
    assert entity.chain.closed
    assert 1e6 * abs(entity.chain.area) == pytest.approx(25.0 * np.pi * 3.0, rel=1e-4)


@pytest.mark.parametrize(
    ("ratio", "wanted"),
    [
        ("", around(60, 40, 20)),
        ("xMinYMin", around(40, 40, 20)),
        ("xMaxYMid meet", around(80, 40, 20)),
        ("xMidYMin slice", around(60, 60, 30)),
        ("xMidYMax slice", around(60, 20, 30)),
        ("none", around(60, 40, 30, 20)),
    ],
)
def test_the_view_box_is_fitted_as_its_aspect_ratio_says(ratio, wanted, tmp_path):
    head = HEAD.replace(
        'viewBox="0 0 120 80"', f'viewBox="0 0 40 40" preserveAspectRatio="{ratio}"'
    )
    head = head.replace(' preserveAspectRatio=""', "")
    drawing = read(tmp_path, '<circle cx="20" cy="20" r="10"/>', head)
    np.testing.assert_allclose(boxes(drawing), [wanted], atol=2e-3)


def test_a_chosen_unit_is_that_of_the_coordinates(tmp_path):
    head = HEAD.replace('width="120mm" height="80mm"', 'width="100%"')
    drawing = read(tmp_path, DOT, head, unit=Unit.INCH)
    np.testing.assert_allclose(boxes(drawing), np.multiply([around(30, 30, 5)], 25.4), rtol=1e-6)


SHOWN = {
    "visibility as an attribute": ('<circle r="5" visibility="hidden"/>', 0),
    "visibility in a style": ('<circle r="5" style="visibility:collapse"/>', 0),
    "visible in a hidden group": (
        '<g visibility="hidden"><circle r="5" visibility="visible"/></g>',
        1,
    ),
    "display by a class whose style stands behind": (
        '<circle r="5" class="a"/><style>.a{display:none}</style>',
        0,
    ),
    "display of a group": ('<g style="display:none"><circle r="5" display="inline"/></g>', 0),
    "a style beats a rule": (
        '<style>circle{display:none}</style><circle r="5" style="display:inline"/>',
        1,
    ),
    "a rule beats an attribute": (
        '<style>#a{stroke:red}</style><circle id="a" stroke="none" r="5"/>',
        1,
    ),
    "what is important beats a style": (
        '<style>circle{display:none!important}</style><circle r="5" style="display:inline"/>',
        0,
    ),
    "the narrower rule wins": (
        '<style>g circle.a{stroke:red}circle{stroke:none}</style><g><circle class="a" r="5"/></g>',
        1,
    ),
    "opacity of a group": ('<g opacity="0"><circle r="5"/></g>', 0),
    "a transparent colour": ('<circle r="5" stroke="rgba(0,0,0,0)"/>', 0),
    "a stroke without width": ('<circle r="5" style="stroke-width:0px"/>', 0),
    "the current colour": ('<g color="transparent"><circle r="5" stroke="currentColor"/></g>', 0),
    "a paint that is missing": ('<circle r="5" stroke="url(#no)"/>', 0),
    "a fallback of a paint that is missing": ('<circle r="5" stroke="url(#no) red"/>', 1),
    "an inherited none": ('<g stroke="none"><circle r="5" stroke="inherit"/></g>', 0),
    "a line that is filled alone": ('<line x2="9" y2="9" fill="red" stroke="none"/>', 0),
    "a hidden use": ('<defs><circle id="c" r="5"/></defs><use href="#c" display="none"/>', 0),
}


@pytest.mark.parametrize("case", SHOWN)
def test_what_does_not_show_is_not_cut_and_noted(case, tmp_path):
    body, shown = SHOWN[case]
    drawing = read(tmp_path, f'<g id="l" transform="translate(50 40)">{body}</g>')
    assert len(drawing.entities) == shown
    assert len(drawing.notes) == 1 - shown


REFUSED = {
    "no number": ('<circle id="c" cx="nan" r="5"/>', "circle #c .*cx is 'nan', which is no length"),
    "a radius below zero": ('<circle id="c" r="-5"/>', r"circle #c .*its r is -5, at \(0, 0\) mm"),
    "no radius": ('<circle id="c" cx="3"/>', r"circle #c .*its r is 0, at \(3, 0\) mm"),
    "a length by the font": ('<rect id="c" width="2em" height="3"/>', "rect #c .*width is '2em'"),
    "a number beyond all": ('<path id="c" d="M1 1H5V5L1e999 2Z"/>', "path #c .*is no number"),
    "a path that breaks off": ('<path id="c" d="M0 0L9 9X3 3"/>', "path #c .*which is no path"),
    "a path without a start": ('<path id="c" d="L9 9"/>', "path #c .*which is no path"),
    "points without an end": (
        '<polygon id="c" points="0,0 9,9 8"/>',
        "polygon #c .*no y",
    ),
    "a transform that is none": ('<circle id="c" r="5" transform="turn(3)"/>', "circle #c .*'turn"),
    "a transform of a group": (
        '<g id="g" transform="scale(nan)"><circle id="c" r="5"/></g>',
        "circle #c on layer g: g #g: its transform is 'nan'",
    ),
    "a use of nothing": ('<use id="u" href="#no"/>', "use #u .*'#no', which is not in"),
    "a use of another file": (
        '<use id="u" href="b.svg#a"/>',
        r"use #u .*'b.svg#a', which is not in",
    ),
    "an id that is there twice": (
        '<defs><circle id="c" r="5"/><circle id="c" r="6"/></defs><use id="u" href="#c"/>',
        "use #u .*'#c', which is more than one element",
    ),
    "a shape outside of its symbol": (
        '<symbol id="s" viewBox="0 0 9 9"><circle id="c" r="5"/></symbol>'
        '<use id="u" href="#s" x="10" y="10" width="9" height="9"/>',
        r"circle #c of use #u .*: symbol #s of use #u clips it at \([\d.]+, -[\d.]+\) mm",
    ),
    "a clip by a class": (
        '<style>.a{clip-path:url(#k)}</style><g id="g" class="a"><circle id="c" r="5"/></g>',
        "circle #c on layer g: g #g has a clip-path",
    ),
    "a filter": ('<circle id="c" r="5" filter="url(#f)"/>', "circle #c .* has a filter"),
    "geometry in a style": (
        '<circle id="c" style="r:5px"/>',
        "its r is set by a style",
    ),
    "a transform in a style": (
        '<circle id="c" r="5" style="transform:rotate(3deg)"/>',
        "circle #c .*its transform is set by a style",
    ),
    "a variable": ('<circle id="c" r="5" style="stroke:var(--a)"/>', "circle #c .*a variable"),
    "no colour": ('<circle id="c" r="5" stroke="blu"/>', "circle #c .*its stroke is 'blu'"),
    "an animation": ('<circle id="c" r="5"><set to="none"/></circle>', "circle #c .*is animated"),
    "text of a use": (
        '<defs><text id="t">8</text></defs><use id="u" href="#t"/>',
        "text #t of use #u on layer .* cannot be cut",
    ),
    "an open fill": (
        '<path id="c" stroke="none" fill="red" d="M0 0H9V9"/>',
        r"path #c .*open by 12.7 mm at \(0, 0\) mm",
    ),
    "a rule of a medium": ("<style>@media print{g{display:none}}</style>", "style '@media print"),
    "a cycle": (
        '<g id="a"><use href="#b"/></g><g id="b"><use href="#a"/></g>',
        "g #a contains itself",
    ),
    "groups too deep": ("<g>" * 500 + "</g>" * 500, "nested more than 100 levels deep"),
    "a transform without area": ('<circle id="c" r="5" transform="scale(1,0)"/>', "leaves no area"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_an_svg_in_doubt_is_refused_by_name_and_place(case, tmp_path):
    body, said = REFUSED[case]
    with pytest.raises(ValueError, match=said) as caught:
        read(tmp_path, body)
    assert "\n" not in str(caught.value)


def bomb():
    levels = ['<g id="g0"><circle r="5"/></g>']
    for i in range(6):
        levels.append(f'<g id="g{i + 1}">' + f'<use href="#g{i}"/>' * 10 + "</g>")
    return f'<defs>{"".join(levels)}</defs><use id="u" href="#g6"/>'


BOMBS = {
    "uses of uses": (bomb, "g #g.* elements, more than 100000"),
    "a path": (
        lambda: '<path id="p" d="M0 0' + " 1 2 3 4" * 500_000 + '"/>',
        "path #p .*it has 1000001 points, more than 100000",
    ),
    "shapes": (lambda: '<circle r="5"/>' * 200_000, "svg .*200001 elements, more than 100000"),
}


@pytest.mark.parametrize("case", BOMBS)
def test_a_bomb_in_svg_is_refused_by_its_count(case, tmp_path):
    """Within 5 s, asks the issue; it takes one."""
    make, said = BOMBS[case]
    body, begun = make(), process_time()
    with pytest.raises(ValueError, match=said):
        read(tmp_path, body)
    assert process_time() - begun < 5.0
