MODULE Dispense
! Sealer on door, two variants. Flow by analog output, gun by TriggEquip.
PERS tooldata tGun:=[TRUE,[[0,0,240],[1,0,0,0]],[3,[0,0,80],[1,0,0,0],0,0,0]];
TASK PERS wobjdata wDoor:=[FALSE,TRUE,"",[[1300,-200,500],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
CONST speeddata vBead:=[150,500,5000,1000];
CONST zonedata zBead:=[FALSE,3,5,5,0.5,5,0.5];
CONST num nFlow{2}:=[4.2,5.6];
CONST robtarget pBead{5}:=[
  [[0,0,2],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]],
  [[150,0,2],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]],
  [[150,120,2],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]],
  [[0,120,2],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]],
  [[0,4,2],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]]];
VAR triggdata gunOn;
VAR triggdata gunOff;
VAR intnum intPurge;
VAR num nPart;

PROC main()
  IDelete intPurge;
  CONNECT intPurge WITH trPurge;
  ISignalDI diPurge,1,intPurge;
  TriggEquip gunOn,0,0.045\DOp:=doGun,1;
  TriggEquip gunOff,8,0.03\DOp:=doGun,0;
  MoveJ Offs(pBead{1},0,0,100),v800,fine,tGun\WObj:=wDoor;
  nPart:=GInput(giPart);
  TEST nPart
  CASE 0,1:
    Bead nFlow{1},0;
  CASE 2:
    Bead nFlow{2},10;
  DEFAULT:
    TPWrite "Unknown part "\Num:=nPart;
    Stop;
  ENDTEST
  MoveL Offs(pBead{Dim(pBead,1)},0,0,100),v800,fine,tGun\WObj:=wDoor;
  InvertDO doCycle;
ENDPROC

PROC Bead(num flow,num shift)
  VAR robtarget p;
  SetAO aoFlow,flow;
  p:=pBead{1};
  p.trans.x:=p.trans.x+shift;
  MoveL Offs(p,-20,0,20),v400,z10,tGun\WObj:=wDoor;
  MoveL p,v200,fine,tGun\WObj:=wDoor;
  FOR i FROM 2 TO Dim(pBead,1) DO
    p:=Offs(pBead{i},shift,0,0);
    IF i=2 THEN
      TriggL p,vBead,gunOn,zBead,tGun\WObj:=wDoor;
    ELSEIF i=Dim(pBead,1) THEN
      TriggL p,vBead,gunOff,fine,tGun\WObj:=wDoor;
    ELSE
      MoveL p,vBead,zBead,tGun\WObj:=wDoor;
    ENDIF
  ENDFOR
  SetAO aoFlow,0;
ENDPROC

TRAP trPurge
  SetDO doPurge,1;
  WaitTime 1;
  SetDO doPurge,0;
  RETURN;
ENDTRAP
ENDMODULE
