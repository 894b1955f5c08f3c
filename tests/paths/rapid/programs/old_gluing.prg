%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%

MODULE GLUING
  CONST robtarget p1:=[[0,0,0],[0,0,1,0],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  CONST robtarget p2:=[[200,0,0],[0,0,1,0],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  CONST robtarget p3:=[[260,60,0],[0,0,1,0],[0,0,0,0],[0,0,0,0,0,0]];
  PERS wobjdata wobj1:=[FALSE,TRUE,"",[[1400,-100,700],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  VAR num reg1:=0;
  VAR bool flag1:=FALSE;

  PROC main()
    ConfJ \Off;
    ConfL \Off;
    MoveJ Offs(p1,0,0,50),v200,fine,tool0 \WObj:=wobj1;
    reg1:=0;
    WHILE reg1<3 DO
      glue reg1*10;
      Incr reg1;
    ENDWHILE
    MoveL Offs(p1,0,0,50), v200, z10, tool0 \WObj:=wobj1;
    WaitTime 0.5;
    Clear reg1;
    flag1:=TRUE;
    EXIT;
  ENDPROC

  PROC glue(num y)
    MoveL Offs(p1,0,y,50),v200,z10,tool0 \WObj:=wobj1;
    MoveL Offs(p1,0,y,0),v100,fine,tool0 \WObj:=wobj1;
    Set do1;
    WaitTime 0.2;
    MoveL Offs(p2,0,y,0),v80,z5,tool0 \WObj:=wobj1;
    MoveL Offs(p3,0,y,0),v80,z5,tool0 \WObj:=wobj1;
    MoveL Offs(p3,0,y+40,0),v80,fine,tool0 \WObj:=wobj1;
    Reset do1;
    IF di1=1 OR flag1 THEN
      TPWrite "glue low";
    ENDIF
    MoveL Offs(p3,0,y+40,50),v200,z10,tool0 \WObj:=wobj1;
  ENDPROC
ENDMODULE
