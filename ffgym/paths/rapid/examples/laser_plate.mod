MODULE LaserPlate
  ! Plate 160 x 120, 2 mm: hole pattern and slot. Laser on at pierce, off 0.5 mm before the end (lag of the source 20 ms).
  PERS tooldata tLaser:=[TRUE,[[100,0,273.2],[0.9659258263,0,0.2588190451,0]],[8,[45,0,122.9],[1,0,0,0],0.05,0.05,0.02]];
  PERS wobjdata wPlate:=[FALSE,TRUE,"",[[1250,-150,600],[1,0,0,0]],[[0,0,2],[1,0,0,0]]];
  CONST jointtarget jHome:=[[0,10,15,0,35,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pRef:=[[0,0,0],[0,0.2588190451,0.9659258263,0],[-1,-1,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST num nClear:=15;
  PERS speeddata vCut:=[35,200,5000,1000];
  VAR triggdata trOn;
  VAR triggdata trOff;

  PROC main()
    AccSet 60,60;
    TriggIO trOn,0\Start\DOp:=doLaser,1;
    TriggEquip trOff,0.5,0.02\DOp:=doLaser,0;
    MoveAbsJ jHome\NoEOffs,v500,fine,tool0;
    WaitDI diClamped,1\MaxTime:=30;
    SetDO doGas,1;
    FOR row FROM 0 TO 1 DO
      FOR col FROM 0 TO 2 DO
        CutHole 40*col+30,30*row+25,4+2*row;
      ENDFOR
    ENDFOR
    CutSlot 30,90,80,8\Slow;
    Reset doGas;
    MoveAbsJ jHome\NoEOffs,v500,fine,tool0;
  ENDPROC

  PROC CutHole(num x,num y,num r)
    VAR robtarget pC;
    pC:=Offs(pRef,x,y,0);
    MoveJ Offs(pC,0,0,nClear),v500,z5,tLaser\WObj:=wPlate;
    MoveL pC,v100,fine,tLaser\WObj:=wPlate;
    TriggL Offs(pC,r,0,0),vCut,trOn,z0,tLaser\WObj:=wPlate;
    MoveC Offs(pC,0,r,0),Offs(pC,-r,0,0),vCut,z0,tLaser\WObj:=wPlate;
    TriggC Offs(pC,0,-r,0),Offs(pC,r,0,0),vCut,trOff,fine,tLaser\WObj:=wPlate;
    MoveL Offs(pC,r,0,nClear),v200,z5,tLaser\WObj:=wPlate;
  ENDPROC

  PROC CutSlot(num x,num y,num len,num wid\switch Slow)
    VAR num r;
    VAR speeddata v;
    r:=wid/2;
    v:=vCut;
    IF Present(Slow) v.v_tcp:=0.7*v.v_tcp;
    MoveJ Offs(pRef,x,y,nClear),v500,z5,tLaser\WObj:=wPlate;
    MoveL Offs(pRef,x,y,0),v100,fine,tLaser\WObj:=wPlate;
    TriggL Offs(pRef,x,y-r,0),v,trOn,z0,tLaser\WObj:=wPlate;
    MoveL Offs(pRef,x+len,y-r,0),v,z0,tLaser\WObj:=wPlate;
    MoveC Offs(pRef,x+len+r,y,0),Offs(pRef,x+len,y+r,0),v,z0,tLaser\WObj:=wPlate;
    MoveL Offs(pRef,x,y+r,0),v,z0,tLaser\WObj:=wPlate;
    TriggC Offs(pRef,x-r,y,0),Offs(pRef,x,y-r,0),v,trOff,fine,tLaser\WObj:=wPlate;
    MoveL Offs(pRef,x,y-r,nClear),v200,z5,tLaser\WObj:=wPlate;
  ENDPROC
ENDMODULE
