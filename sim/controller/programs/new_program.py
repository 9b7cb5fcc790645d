"""A new program for the contours of a part: control points, and zones of half their spacing.

Its tool is the bare flange and its work object the robot's base, as in a run. What only the robot's
owner knows is not guessed: the header says what must be set before it runs.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.sparse.linalg import splu
from scipy.spatial import KDTree

from armside.arrays import Array
from armside.kinematics.rotation import from_quaternion, to_axis_angle, to_roll_pitch_yaw

from ...part.motion import CutLeg, PartMotion
from .program_text import UNIT, Language
from .scanner import Text
from .tool_path import Row, arc_lengths

CLOSE = 0.49
"""URScript: radius of a blend over the smallest spacing, as blends must not overlap."""
PER_TARGET = 20
"""Places at which a contour is fitted, for each of its targets."""
APPROACH = 0.05
"""Height of the first point over the first contour [m], along the base's z axis."""
SET_FIRST = "Set the axis configuration in it before it runs: its header says where"
MOST_TARGETS = 20_000
ENDINGS = {"rapid": ".mod", "krl": ".src", "urscript": ".script"}
_MOVE = "    {} @, {}, {}, tool0\\WObj:=wobj0;"
FORMS: dict[Language, dict[str, str]] = {
    "rapid": {
        "head": """MODULE armside
  ! Written by armside: {about}. mm, mm/s, quaternion w x y z.
  ! Tool tool0: the bare flange. Work object wobj0: the robot's base.
  ! SET confHere: [0,0,0,0] is a placeholder for the axis configuration of your robot here.
  CONST confdata confHere := [0,0,0,0];
  CONST speeddata vCut := [{cut:g},500,5000,1000];
  CONST speeddata vRapid := [{rapid:g},500,5000,1000];
  CONST zonedata zCut := [FALSE,{zone:.3f},{zone:.3f},{zone:.3f},1,{zone:.3f},1];
  PROC main()""",
        "note": "    ! ",
        "joint": _MOVE.format("MoveJ", "v100", "fine"),
        "rapid": _MOVE.format("MoveL", "vRapid", "fine"),
        "cut": _MOVE.format("MoveL", "vCut", "zCut"),
        "stop": _MOVE.format("MoveL", "vCut", "fine"),
        "tail": "  ENDPROC\nENDMODULE\n",
        "pose": "[[{:.4f},{:.4f},{:.4f}],[{:.9f},{:.9f},{:.9f},{:.9f}],confHere,"
        "[9E9,9E9,9E9,9E9,9E9,9E9]]",
    },
    "krl": {
        "head": """DEF armside( )
;Written by armside: {about}. mm, m/s, deg, R = Rz(A) Ry(B) Rx(C).
;Tool: the bare flange. Base: the robot's own.
;SET S and T of the first point, the axis configuration of your robot: none is given.
BAS (#INITMOV,0 )
$TOOL=$NULLFRAME
$BASE=$NULLFRAME
$IPO_MODE=#BASE
$APO.CDIS={zone:.3f}""",
        "note": ";",
        "joint": "PTP @",
        "rapid": "$VEL.CP={rapid:g}\nLIN @\n$VEL.CP={cut:g}",
        "cut": "LIN @ C_DIS",
        "stop": "LIN @",
        "tail": "END\n",
        "pose": "{{X {:.4f},Y {:.4f},Z {:.4f},A {:.7f},B {:.7f},C {:.7f}}}",
    },
    "urscript": {
        "head": """# Written by armside: {about}. m, m/s, rad, rotation vector.
# TCP: the bare flange. Poses in the robot's base.
# SET the robot near its first pose by hand: movej takes the nearest joint angles.
def armside():
  set_tcp(p[0, 0, 0, 0, 0, 0])""",
        "note": "  # ",
        "joint": "  movej(@, a=1.4, v=0.5)",
        "rapid": "  movel(@, a=1.2, v={rapid:g}, r=0)",
        "cut": "  movel(@, a=1.2, v={cut:g}, r={zone:.6f})",
        "stop": "  movel(@, a=1.2, v={cut:g}, r=0)",
        "tail": "end\n",
        "pose": "p[{:.7f}, {:.7f}, {:.7f}, {:.9f}, {:.9f}, {:.9f}]",
    },
}
"""Lines of each language; @ is a pose."""


@dataclass(frozen=True, kw_only=True)
class NewProgram:
    """Text of a new program, and how it follows the contours."""

    text: Text = field(repr=False)
    targets: int
    spacing: float
    """[m]."""
    chord_error: float
    """Largest distance of its path from the contours [m]."""
    blocks_per_second: float

    @property
    def line(self) -> str:
        """What a person has to know, in a line."""
        targets = f"{self.targets} targets, {1e3 * self.spacing:.3g} mm apart"
        blocks = f"up to {self.blocks_per_second:.3g} blocks/s"
        error = f"chord error {1e6 * self.chord_error:.3g} µm"
        return f"{self.text.name}: {targets}; {blocks}; {error}. {SET_FIRST}"


def automatic_spacing(motion: PartMotion, pass_band: float) -> float:
    """Spacing [m] for a pass band f [Hz]: v / (2 f), at most half of the smallest radius."""
    radii = [1.0 / np.abs(cut.path.curvature).max(initial=1e-9) for cut in motion.cuts]
    by_speed = min(cut.asked_speed for cut in motion.cuts) / (2.0 * pass_band)
    return min(by_speed, 0.5 * min(radii))


def new_program(
    motion: PartMotion,
    language: Language,
    spacing: float,
    rapid: float,
    rows: Sequence[Row] | None = None,
) -> NewProgram:
    """Program for all cuts of a motion, leads included, with straight moves between them.

    spacing: [m], at most, of targets. rapid: [m/s]. rows: of each cut, in place of those that
    follow it best. Raises ValueError for too many targets.
    """
    count = sum(_targets(cut.path.length, spacing) for cut in motion.cuts)
    if count > MOST_TARGETS:
        raise ValueError(f"{1e3 * spacing:g} mm make {count} targets, at most {MOST_TARGETS}")
    fits = [fitted(contour_in_base(motion, c), c.path.length, spacing) for c in motion.cuts]
    own = [row for row, _ in fits] if rows is None else rows
    closest = min(float(row.spacing.min()) for row in own)
    speed, form = motion.cuts[0].asked_speed, FORMS[language]
    length, turn = 1.0 / UNIT[language], _orientation(motion, language)
    unit = 1e3 if language == "rapid" else 1.0
    zone = CLOSE * closest if language == "urscript" else spacing / 2.0
    numbers: dict[str, Any] = {
        "about": f"{1e3 * speed:g} mm/s, {1e3 * spacing:.3g} mm between targets",
        "cut": unit * speed,
        "rapid": unit * rapid,
        "zone": length * zone,
    }
    lines = [form["head"].format(**numbers)]

    def add(kind: str, at: Array) -> None:
        pose = form["pose"].format(*(length * at), *turn)
        lines.append(form[kind].format(**numbers).replace("@", pose))

    start = motion.to_base(motion.cuts[0].path.point(0.0))
    add("joint", start + np.array([0.0, 0.0, APPROACH]))
    for row, cut in zip(own, motion.cuts, strict=True):
        add("rapid", row.targets[0])
        plain = "".join(c if c.isascii() and c.isprintable() else "?" for c in cut.name)
        lines.append(f"{form['note']}beam on: {plain}")
        for at in row.targets[1:-1]:
            add("cut", at)
        add("stop", row.targets[-1])
        lines.append(f"{form['note']}beam off")
    return NewProgram(
        text=Text(f"armside{ENDINGS[language]}", "\n".join([*lines, form["tail"]])),
        targets=count,
        spacing=spacing,
        chord_error=max(far for _, far in fits),
        blocks_per_second=speed / closest,
    )


def _targets(length: float, spacing: float) -> int:
    return max(int(np.ceil(length / spacing - 1e-9)), 3) + 1


def contour_in_base(motion: PartMotion, cut: CutLeg) -> Callable[[Array], Array]:
    """Points (K, 3) [m] of a cut in base axes, at arc lengths (K,) [m]."""
    return lambda s: motion.to_base(cut.path.point(s))


def fitted(point: Callable[[Array], Array], length: float, spacing: float) -> tuple[Row, float]:
    """Control points of a path (points at arc lengths [m]) by least squares, its ends exact, at
    most a spacing [m] apart, and their largest error [m]."""
    n = _targets(length, spacing)
    s, zones = np.linspace(0.0, length, PER_TARGET * n), np.full(n, spacing / 2.0)
    goal, targets = point(s), point(np.linspace(0.0, length, n))
    row = Row(moves=tuple(range(n)), targets=targets, zones=zones)
    for _ in range(4):  # places follow the length of the path, which moves less and less
        w = row.samples(spacing / PER_TARGET)
        along = arc_lengths(row.path(w))
        N = row.basis(np.interp(s * along[-1] / length, along, w)).tocsc()
        rest, inner = goal - N[:, [0, -1]] @ targets[[0, -1]], N[:, 1:-1]
        found = splu((inner.T @ inner).tocsc()).solve(inner.T @ rest)
        row = replace(row, targets=np.vstack([targets[:1], found, targets[-1:]]))
    away = KDTree(row.path(row.samples(spacing / PER_TARGET))).query(goal)[0]
    return row, float(away.max())


def _orientation(motion: PartMotion, language: Language) -> Array:
    """Constant orientation of the tool in the language's numbers."""
    R = from_quaternion(motion.tool_quaternion)
    if language == "rapid":
        return np.array(motion.tool_quaternion)
    if language == "krl":
        return np.degrees(to_roll_pitch_yaw(R))
    axis, angle = to_axis_angle(R)
    return axis * angle
