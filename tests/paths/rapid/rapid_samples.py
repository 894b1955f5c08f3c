"""RAPID programs of every kind that is supported, and small ones around single statements."""

from ffgym.paths.moves import Move, MoveArc, MoveJoint, MoveLinear, Pose, Wait
from ffgym.paths.rapid import parse_program
from ffgym.robot import RobotDescription

TARGET = "[[1300, -200, 600], [0, 0, 1, 0], [-1, 0, -1, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]]"
"""Position 1 of the built-in robot's work area, z of the tool down."""

EXPORTED = r"""MODULE Module1
    PERS tooldata Nozzle:=[TRUE,[[100,0,273.2],[0.965925826,0,0.258819045,0]],
        [8,[45,0,122.9],[1,0,0,0],0.05,0.05,0.02]];
    CONST robtarget Target_10:=[[1300,-200,600],[0,0,1,0],[-1,0,-1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget Target_20:=[[1320,-200,600],[0,0,1,0],[-1,0,-1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget Target_30:=[[1320,-180,600],[0,0,1,0],[-1,0,-1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
!***********************************************************
!
! Module:  Module1
!
!***********************************************************
    PROC main()
        !Add your code here
        Path_10;
    ENDPROC
    PROC Path_10()
        MoveJ Target_10,v1000,fine,Nozzle\WObj:=wobj0;
        MoveL Target_20,v10,z10,Nozzle\WObj:=wobj0;
        MoveL Target_30,v10,fine,Nozzle\WObj:=wobj0;
    ENDPROC
ENDMODULE
"""
"""As an off-line programming system writes it."""

ARITHMETIC = r"""
! no module, everything in lower case
const robtarget p0 := [[1300, -200, 600], [0, 0, 1, 0], [0, 0, 0, 0], [9e9, 9e9, 9e9, 9e9, 9e9, 9e9]];
const num pitch := 2.5e1;
var robtarget p;
var speeddata slow := v20;
proc cut()
  var num depth := -(2 + 3) * 2;
  p := offs(p0, pitch, 2 * pitch / 4, depth);
  movej p, v100, fine, trobot;
  p.trans.z := p.trans.z - depth;
  slow.v_tcp := slow.v_tcp / 2;
  movel p, slow, z5, trobot;
  movec reltool(p0, 0, 0, 10), offs(p, 0, 2 * pitch, 0), slow\v:=7, [false, 3, 4, 4, 0.4, 4, 0.4], trobot;
  movel offs(p, 0, 2 * pitch, 5), slow, z5\z:=1, trobot;
  p := p0;
  movel p, vmax, fine, trobot;
  waittime \inpos, 1 / 4;
endproc
"""
"""Own data, arithmetic and components."""

JOINTS = r"""%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%
MODULE m(SYSMODULE, NOSTEPIN)
  LOCAL CONST jointtarget jHome := [[0, 10, 15, 0, 35, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  TASK PERS jointtarget jOut := [[10, 10, 15, -20, 35, 90], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  LOCAL PROC main()
    ConfJ \On; ConfL \Off; SingArea \Off; AccSet 100, 100;
    MoveAbsJ jHome\NoEOffs, v1000, fine, tool0;
    MoveAbsJ [[5, 10, 15, 0, 35, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]], v200, z50, tool0\WObj:=wobj0;
    MoveAbsJ jOut, v200, fine, tool0;
  ENDPROC
ENDMODULE
"""
"""Joint space only, in an old file format."""

WORK_OBJECT = r"""MODULE plate
  PERS wobjdata wPlate := [FALSE, TRUE, "", [[1400, 0, 500], [0.707106781187, 0, 0, 0.707106781187]],
    [[0, 0, 20], [1, 0, 0, 0]]];
  PERS tooldata tPen := [TRUE, [[0, 0, 200], [1, 0, 0, 0]], [1, [0, 0, 60], [1, 0, 0, 0], 0, 0, 0]];
  CONST robtarget pCorner := [[0, 0, 0], [0, 0.707106781187, 0.707106781187, 0], [0, 0, 0, 0],
    [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  PROC main()
    ConfJ \Off;
    MoveJ Offs(pCorner, 10, 0, 50), v100, fine, tPen\WObj:=wPlate;
    side; side;
  ENDPROC
  PROC side()
    MoveL Offs(pCorner, 10, 0, 0), v50, fine, tPen\WObj:=wPlate;
    MoveL Offs(pCorner, 10, 30, 0), v50, z1, tPen\WObj:=wPlate;
  ENDPROC
ENDMODULE
"""
"""Targets of a plate that is turned by a quarter, a tool without moments, a procedure that runs twice."""

GOLDEN = {"exported": EXPORTED, "arithmetic": ARITHMETIC, "joints": JOINTS, "work object": WORK_OBJECT}


def program(body: str, data: str = "", more: str = "") -> str:
    """Program around statements, which start in line 6; `data` is line 2, `more` are other procedures."""
    return f"""MODULE m
{data}
CONST robtarget p := {TARGET};
PROC main()
MoveJ p, v100, fine, tRobot;
{body}
ENDPROC
{more}
ENDMODULE
"""


def moves(robot: RobotDescription, text: str, entry: str | None = None) -> tuple[Move, ...]:
    """Moves of a program."""
    return parse_program(text, "cut.mod").execute(robot, entry).moves


def moves_of(robot: RobotDescription, body: str, data: str = "", more: str = "") -> tuple[Move, ...]:
    """Moves of the statements in `program`, without its first move."""
    return moves(robot, program(body, data, more))[1:]


def told(move: Move) -> tuple[object, ...]:
    """A move in words and in the units of RAPID: kind, label, target, via, speed, zone."""
    kind = type(move).__name__
    if isinstance(move, Wait):
        return (kind, move.duration)
    assert isinstance(move, MoveArc | MoveJoint | MoveLinear)
    target = [round(x * 1e3, 6) for x in move.to.position] if isinstance(move.to, Pose) else list(move.to.round(6))
    via = [round(x * 1e3, 6) for x in move.via] if isinstance(move, MoveArc) else None
    assert move.speed is not None
    return (kind, move.label, target, via, round(move.speed.tcp * 1e3, 9), round(move.zone.radius * 1e3, 9))
