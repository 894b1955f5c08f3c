MODULE thesis_circles
  ! The test motion of the thesis (2.2.5): circles of 1, 3 and 5 mm around one point, at 10 mm/s.
  ! Each circle is led in from the centre and out again on a half circle of half its radius.

  ! The built-in robot's cutting head: the nozzle leans 30 deg towards x of the flange.
  PERS tooldata tNozzle := [TRUE, [[100, 0, 273.2], [0.965925826289, 0, 0.258819045103, 0]],
    [8, [45, 0, 122.9], [1, 0, 0, 0], 0.05, 0.05, 0.02]];

  ! Position 1 of the work area, nozzle down.
  CONST robtarget pCentre := [[1300, -200, 600], [0, 0, 1, 0], [-1, 0, -1, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];

  CONST speeddata vCut := [10, 500, 5000, 1000];
  ! z0 would round the joint of lead and circle over 0.3 mm, which is a third of the smallest radius.
  CONST zonedata zJoint := [FALSE, 0.003, 0.003, 0.003, 0.01, 0.003, 0.01];
  VAR num r := 1;

  PROC main()
    MoveJ pCentre, v100, fine, tNozzle;
    WaitTime 0.3;
    r := 1;
    cutCircle;
    r := 3;
    cutCircle;
    r := 5;
    cutCircle;
  ENDPROC

  ! A circle of radius r, joined below the centre (at -y), counter-clockwise seen from above.
  PROC cutCircle()
    MoveC Offs(pCentre, -r/2, -r/2, 0), Offs(pCentre, 0, -r, 0), vCut, zJoint, tNozzle;
    MoveC Offs(pCentre, r, 0, 0), Offs(pCentre, 0, r, 0), vCut, zJoint, tNozzle;
    MoveC Offs(pCentre, -r, 0, 0), Offs(pCentre, 0, -r, 0), vCut, zJoint, tNozzle;
    MoveC Offs(pCentre, r/2, -r/2, 0), pCentre, vCut, fine, tNozzle;
    WaitTime 0.3;
  ENDPROC
ENDMODULE
