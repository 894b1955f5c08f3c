MODULE cut_bracket
  ! A plate of 80 x 50 mm with a rounded corner, a slot and a hole, cut on a table that is turned by 30 deg.
  ! The nozzle stands upright on it, and the flange as it does in the robot's work area.
  ! Coordinates of the targets are those of the plate: x along its long side, y across, z up.

  PERS tooldata tNozzle := [TRUE, [[100, 0, 273.2], [0.965925826289, 0, 0.258819045103, 0]],
    [8, [45, 0, 122.9], [1, 0, 0, 0], 0.05, 0.05, 0.02]];
  PERS wobjdata wPlate := [FALSE, TRUE, "", [[1450, -100, 560], [0.965925826289, 0, 0, 0.258819045103]],
    [[0, 0, 10], [1, 0, 0, 0]]];

  CONST jointtarget jHome := [[0, 10, 15, 0, 35, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST robtarget pOrigin := [[0, 0, 0], [0, 0.258819045103, 0.965925826289, 0], [-1, 0, -1, 0],
    [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];

  CONST speeddata vCut := [40, 500, 5000, 1000];
  CONST num clearance := 20;
  VAR robtarget pStart;

  PROC main()
    MoveAbsJ jHome\NoEOffs, v200, fine, tool0;
    cutHole;
    cutSlot;
    cutOutline;
    MoveAbsJ jHome\NoEOffs, v200, fine, tool0;
  ENDPROC

  ! Move above the start of a cut, go down, and wait for the jet to pierce.
  PROC pierce()
    MoveJ Offs(pStart, 0, 0, clearance), v200, fine, tNozzle\WObj:=wPlate;
    MoveL pStart, v50, fine, tNozzle\WObj:=wPlate;
    WaitTime 0.2;
  ENDPROC

  PROC retract()
    MoveL Offs(pStart, 0, 0, clearance), v100, fine, tNozzle\WObj:=wPlate;
  ENDPROC

  ! Hole of 10 mm, from its middle.
  PROC cutHole()
    pStart := Offs(pOrigin, 20, 25, 0);
    pierce;
    MoveL Offs(pStart, 5, 0, 0), vCut, z1, tNozzle\WObj:=wPlate;
    MoveC Offs(pStart, 0, 5, 0), Offs(pStart, -5, 0, 0), vCut, z1, tNozzle\WObj:=wPlate;
    MoveC Offs(pStart, 0, -5, 0), Offs(pStart, 5, 0, 0), vCut, fine, tNozzle\WObj:=wPlate;
    retract;
  ENDPROC

  ! Slot of 20 x 8 mm with round ends.
  PROC cutSlot()
    pStart := Offs(pOrigin, 40, 21, 0);
    pierce;
    MoveL Offs(pStart, 20, 0, 0), vCut, z1, tNozzle\WObj:=wPlate;
    MoveC Offs(pStart, 24, 4, 0), Offs(pStart, 20, 8, 0), vCut, z1, tNozzle\WObj:=wPlate;
    MoveL Offs(pStart, 0, 8, 0), vCut, z1, tNozzle\WObj:=wPlate;
    MoveC Offs(pStart, -4, 4, 0), pStart, vCut, fine, tNozzle\WObj:=wPlate;
    retract;
  ENDPROC

  ! Outline, corners rounded within 2 mm, the last one with a radius of 10 mm.
  PROC cutOutline()
    VAR zonedata zCorner := [FALSE, 2, 3, 3, 0.3, 3, 0.3];
    pStart := pOrigin;
    pierce;
    MoveL Offs(pStart, 80, 0, 0), vCut, zCorner, tNozzle\WObj:=wPlate;
    MoveL Offs(pStart, 80, 50, 0), vCut, zCorner, tNozzle\WObj:=wPlate;
    MoveL Offs(pStart, 10, 50, 0), vCut\V:=30, z1, tNozzle\WObj:=wPlate;
    MoveC Offs(pStart, 10 - 7.0711, 40 + 7.0711, 0), Offs(pStart, 0, 40, 0), vCut\V:=30, z1, tNozzle\WObj:=wPlate;
    MoveL pStart, vCut, fine, tNozzle\WObj:=wPlate;
    retract;
  ENDPROC
ENDMODULE
