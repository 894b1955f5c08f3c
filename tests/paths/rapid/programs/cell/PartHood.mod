MODULE PartHood
  LOCAL CONST robtarget pStart:=[[1350,100,650],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL PERS num nSides:=6;

  PROC CutHood()
    VAR num a;
    MoveJ Offs(Corner(0),0,0,60),v800,z10,tCutter;
    MoveL Corner(0),v200,fine,tCutter;
    Set doCutter;
    FOR i FROM 1 TO nSides DO
      a:=360*i/nSides;
      IF i=nSides THEN
        MoveL Corner(a),vFeed,fine,tCutter;
      ELSE
        MoveL Corner(a),vFeed,z1,tCutter;
      ENDIF
    ENDFOR
    Reset doCutter;
    Retract;
    nPartsTotal:=nPartsTotal+1;
  ENDPROC

  LOCAL FUNC robtarget Corner(num angle)
    RETURN Offs(pStart,50*Cos(angle),50*Sin(angle),0);
  ENDFUNC
ENDMODULE
