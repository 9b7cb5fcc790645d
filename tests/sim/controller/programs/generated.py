"""Programs drawn at random, with what they mean by an independent computation."""

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

LANGUAGES = {"rapid": ".mod", "krl": ".src", "urscript": ".script"}
FAR = ",".join(["9E9"] * 6)


@dataclass
class Drawn:
    """Text of a program, and its moves: kind, position [m], rotation, speed [m/s], zone [m]."""

    name: str
    content: str = ""
    moves: list[tuple[str, np.ndarray, Rotation, float | None, float]] = field(default_factory=list)


def draw(language: str, seed: int) -> Drawn:
    """A program of 3 to 12 moves in a routine of its own, spelled at random."""
    rng = np.random.default_rng([seed, len(language)])
    program = Drawn(f"drawn{LANGUAGES[language]}")
    lines = _moves(language, rng, program)
    space = ["", " ", "\t", "  "]

    def spelled(line: str) -> str:
        end = rng.choice(["", f" {COMMENT[language]} LIN MoveL p[1] {{", " "])
        return rng.choice(space) + line + end

    body = [spelled(line) for line in lines]
    break_ = str(rng.choice(["\n", "\r\n"]))
    head, tail = FRAME[language]
    program.content = break_.join([*head, *body, *tail, ""])
    if language != "urscript" and rng.random() < 0.5:
        program.content = program.content.replace("Move", "MOVE").replace("LIN ", "lin ")
    return program


COMMENT = {"rapid": "!", "krl": ";", "urscript": "#"}
FRAME = {
    "rapid": (
        ["MODULE m", "PROC main()", "part;", "ENDPROC", "PROC part()"],
        ["ENDPROC", "ENDMODULE"],
    ),
    "krl": (["&ACCESS RVP", "DEF m( )", "part()", "END", "DEF part( )"], ["END"]),
    "urscript": (["def m():", "  part()", "end", "def part():"], ["end", "m()"]),
}


def _moves(language: str, rng: np.random.Generator, program: Drawn) -> list[str]:
    lines = list[str]()
    for i in range(int(rng.integers(3, 13))):
        position = rng.uniform(-2.0, 2.0, 3)
        rotation = Rotation.random(rng=rng)
        speed, zone = float(rng.integers(1, 400)), float(rng.integers(0, 40)) / 4
        linear = i > 0 and rng.random() < 0.8
        write = {"rapid": _rapid, "krl": _krl, "urscript": _urscript}[language]
        added, exact = write(rng, position, rotation, speed, zone, linear)
        lines += added
        size = 1e-3 * zone if linear or language != "krl" else 0.0
        along = 1e-3 * speed if linear or language == "rapid" else None
        program.moves.append(("MoveL" if linear else "MoveJ", exact, rotation, along, size))
    return lines


def _length(rng, value):
    """A length in one of its spellings, and what is then written."""
    decimals = int(rng.integers(0, 7))
    text = f"{value:.{decimals}f}" if rng.random() < 0.8 else f"{value:.{decimals}e}"
    return text, float(text)


def _lengths(rng, position, unit):
    pairs = [_length(rng, value / unit) for value in position]
    return [text for text, _ in pairs], unit * np.array([value for _, value in pairs])


def _rapid(rng, position, rotation, speed, zone, linear):
    texts, exact = _lengths(rng, position, 1e-3)
    q = ",".join(f"{v:.12f}" for v in rotation.as_quat(scalar_first=True))
    target = f"[[{', '.join(texts)}],[{q}],[0,-1,0,1],[{FAR}]]"
    if rng.random() < 0.3:
        by = rng.integers(-50, 50, 3) / 4
        exact, target = exact + 1e-3 * by, f"Offs({target},{by[0]:g},{by[1]:g},{by[2]:g})"
    z = f"[FALSE,{zone:g},1,1,1,1,1]"
    word = "MoveL" if linear else "MoveJ"
    return [f"{word} {target},[{speed:g},500,5000,1000], {z}, tool0\\WObj:=wobj0;"], exact


def _krl(rng, position, rotation, speed, zone, linear):
    texts, exact = _lengths(rng, position, 1e-3)
    a, b, c = rotation.as_euler("ZYX", degrees=True)
    x, y, z = texts
    target = f"{{X {x},Y {y},Z {z},A {a:.12f},B {b:.12f},C {c:.12f},S 'B010',T 27}}"
    if rng.random() < 0.3:
        by = rng.integers(-50, 50, 3) / 4
        exact = exact + rotation.apply(1e-3 * by)
        target += f":{{X {by[0]:g},Y {by[1]:g},Z {by[2]:g},A 0,B 0,C 0}}"
    if not linear:
        return [f"PTP {target}"], exact
    return [f"$VEL.CP={1e-3 * speed:.6g}", f"$APO.CDIS = {zone:g}", f"LIN {target} C_DIS"], exact


def _urscript(rng, position, rotation, speed, zone, linear):
    texts, exact = _lengths(rng, position, 1.0)
    turn = ", ".join(f"{v:.12f}" for v in rotation.as_rotvec())
    target = f"p[{', '.join(texts)}, {turn}]"
    if rng.random() < 0.3:
        by = rng.integers(-50, 50, 3) / 4e3
        exact, target = exact + by, f"pose_add({target}, p[{by[0]:g}, {by[1]:g}, {by[2]:g}, 0,0,0])"
    word = rng.choice(["movel", "movep"]) if linear else "movej"
    given = f"a=1.2, v={1e-3 * speed:.6g}, r={1e-3 * zone:.6g}"
    return [f"{word}({target}, {given})"], exact


HAND_WRITTEN = {
    ".mod": r"""%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%
MODULE Part(SYSMODULE, NOVIEW)
  ! laser head, measured on Tuesday: IF you move it, FOR a week nothing fits
  PERS tooldata tLaser := [TRUE,[[10,-20,150],[0.7071067811865476,0,0.7071067811865476,0]],
    [2,[0,0,80],[1,0,0,0],0,0,0]];
  TASK PERS wobjdata wTable := [FALSE,TRUE,"",
    [[800,0,500],[0.7071067811865476,0,0,0.7071067811865476]],
    [[5,0,0],[1,0,0,0]]];
  LOCAL CONST zonedata zHalf := [FALSE,1,1.5,1.5,0.1,1.5,0.1];
  CONST speeddata vCut:=[4.0E1,500,5000,1000];
  CONST confdata cHere := [0,-1,0,1];
  CONST jointtarget jHome := [[0,-30,30,0,90,0],[1200.5,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pStart := [[ 0 , 0.0, 0.000 ],[1,0,0,0],cHere,[1200.5,9E9,9E9,9E9,9E9,9E9]];
  VAR num nParts := 0;
  PROC main()
    ConfL\Off;
    SingArea\Wrist;
    MoveAbsJ jHome\NoEOffs, vmax, fine, tLaser;
    MoveJ Offs(pStart, 0, 0, +50), v500, z10, tLaser\WObj:=wTable;
    MOVEL pStart, v100, fine, tLaser\WObj:=wTable;
    SetDO doLaser, 1; WaitTime 0.3;
    contour;
    SetDO doLaser, 0;
    MoveL Offs(pStart,0,0,50), v500, fine, tLaser\WObj:=wTable;
  ENDPROC
  LOCAL PROC contour()
    MoveL [[2,0.5,-0.],[1,0,0,0],cHere,[1200.5,9E9,9E9,9E9,9E9,9E9]],vCut,zHalf,tLaser\WObj:=wTable;
    MoveL [[4,.25,0],[1,0,0,0],[0,-1,0,1],[1200.5,9E9,9E9,9E9,9E9,9E9]],vCut,z1,tLaser\WObj:=wTable;
    MoveC Offs(pStart,6,2,0), Offs(pStart,4,4,0), vCut, fine, tLaser\WObj:=wTable;
  ENDPROC
ENDMODULE
""",
    ".src": """&ACCESS RVP
&REL 17
DEF part( )
;FOLD INI;%{PE}
 GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )
 INTERRUPT ON 3
 BAS (#INITMOV,0 )
;ENDFOLD (INI)
DECL E6POS XLOCAL
$ADVANCE=3
$IPO_MODE=#BASE
$TOOL=$NULLFRAME
BASE_DATA[1]={X 800,Y 0,Z 500,A 90,B 0,C 0}
PTP {A1 0,A2 -90,A3 90,A4 0,A5 45,A6 0,E1 1200.5}
;FOLD LIN P1 CONT Vel=0.2 m/s CPDAT1 Tool[1] Base[0];%{PE}%R 8.3
$BWDSTART=FALSE
LDAT_ACT=LCPDAT1
FDAT_ACT=FP1
BAS(#CP_PARAMS,0.2)
LIN XP1 C_DIS
;ENDFOLD
$OUT[3]=TRUE
WAIT SEC 0.3
$VEL.CP = 4.0E-2   ; 40 mm/s
contour()
PTP XP1:{X 0,Y 0,Z -50,A 0,B 0,C 0} C_PTP
END

DEF contour( )
LIN {X 2, Y 0.5,Z -0.,A 10.0,B 0,C 0,E1 1200.5} C_DIS
LIN {X 4,Y .25,Z 0,A 10.0,B 0,C 0,E1 1200.5} C_DIS
XLOCAL={X 6,Y 2,Z 0,A 10,B 0,C 0}
CIRC XLOCAL, {X 4,Y 4,Z 0,A 10,B 0,C 0}
END
""",
    ".dat": """&ACCESS RVP
DEFDAT part PUBLIC
;FOLD EXTERNAL DECLARATIONS
EXT BAS (BAS_COMMAND :IN,REAL :IN )
DECL INT SUCCESS
;ENDFOLD
DECL E6POS XP1={X 0,Y 0.0,Z 0.000,A 10.0,B 0,C 0,S 2,T 27,E1 1200.5,E2 0.0}
DECL FDAT FP1={TOOL_NO 1,BASE_NO 1,IPO_FRAME #BASE,POINT2[] " "}
DECL LDAT LCPDAT1={VEL 2.0,ACC 100.0,APO_DIST 1.5,APO_FAC 50.0,ORI_TYP #VAR}
ENDDAT
""",
    ".script": """# if it stops: while you wait, for a time
def part():
  # begin: URCap Laser
  set_gravity([0.0, 0.0, 9.82])
  set_tcp(p[0.01, -0.02, 0.15, 0, 1.5707963267948966, 0])
  set_payload(2.0, [0, 0, 0.08])
  global Table = p[0.8, 0, 0.5, 0, 0, 1.5707963267948966]
  global Start=p[ 0 , 0.0, 0.000, 0, 3.1415, 0]
  v_cut = 4.0E-2
  def contour():
    movel(pose_trans(Table, p[0.002, 0.0005, -0., 0, 3.1415, 0]), 1.2, v_cut, 0, 0.0008)
    movep(pose_trans(Table, p[0.004,.00025,0, 0,3.1415,0]), a=1.2, v=v_cut, r=0.0008)
    movel(pose_trans(Table, p[0.006, 0.001, 0, 0,3.1415,0]), v=v_cut)
    global End = p[0.006,0.003,0,0,3.1415,0]
    movec(pose_trans(Table, p[0.008,0.002,0,0,3.1415,0]), pose_trans(Table, End), v=v_cut, mode=1)
  end
  movej([0, -1.57, 1.57, -1.57, -1.57, 0], a=1.4, v=1.05)
  movej(pose_add(Start, p[0, 0, 0.05, 0, 0, 0]), r=0.01)
  movel(pose_trans(Table, Start), a=1.2, v=0.1)
  set_digital_out(3, True)
  sleep(0.3)
  contour()
  set_digital_out(3, False)
  textmsg("done: movel(p[1])")
  movel(pose_add(Start, p[0, 0, 0.05, 0, 0, 0]))
end
part()
""",
}
