MODULE MainModule
  VAR num nPart:=1;
  CONST string stParts{2}:=["Door","Hood"];
  CONST jointtarget jHome:=[[0,10,15,0,35,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

  PROC main()
    MoveAbsJ jHome,v1000,fine,tool0;
    FOR i FROM 1 TO Dim(stParts,1) DO
      nPart:=i;
      stLast:=stParts{i};
      ! the part's module has a procedure of its own name
      %"Cut"+stLast%;
    ENDFOR
    MoveAbsJ jHome,v1000,fine,tool0;
  ENDPROC
ENDMODULE
