MODULE PartDoor
  LOCAL CONST robtarget pStart:=[[1300,-200,600],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

  PROC CutDoor()
    MoveJ Offs(pStart,0,0,60),v800,z10,tCutter;
    MoveL pStart,v200,fine,tCutter;
    Set doCutter;
    Side pStart,80,0;
    Side Offs(pStart,80,0,0),0,60;
    Reset doCutter;
    Retract;
    nPartsTotal:=nPartsTotal+1;
  ENDPROC

  LOCAL PROC Side(robtarget pFrom,num dx,num dy)
    MoveL Offs(pFrom,dx,dy,0),vFeed,fine,tCutter;
  ENDPROC
ENDMODULE
