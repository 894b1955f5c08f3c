MODULE Module1
    PERS tooldata AW_Gun:=[TRUE,[[119.5,0,352],[0.890213785,0,0.455543074,0]],[1,[0,0,100],[1,0,0,0],0,0,0]];
    TASK PERS wobjdata Workobject_1:=[FALSE,TRUE,"",[[1250,-200,450],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
    CONST robtarget Target_10:=[[0,0,120.000000015],[0.000000028,0.455543074,0.890213785,0],[0,-1,1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget Target_20:=[[0,0,0],[0.000000028,0.455543074,0.890213785,0],[0,-1,1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget Target_30:=[[99.999999702,0,0.000000142],[0,0.455543074,0.890213785,0.000000031],[0,-1,1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget Target_40:=[[135.355339059,14.644660941,0],[0,0.455543074,0.890213785,0],[0,-1,1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget Target_50:=[[150,50,0],[0,0.455543074,0.890213785,0],[0,-1,1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget Target_60:=[[150,180,0],[0,0.455543074,0.890213785,0],[0,-1,1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST jointtarget JointTarget_1:=[[0,0,0,0,30,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    !***********************************************************
    !
    ! Module:  Module1
    !
    ! Description:
    !   <Insert description here>
    !
    ! Author: Station
    !
    ! Version: 1.0
    !
    !***********************************************************


    !***********************************************************
    !
    ! Procedure main
    !
    !   This is the entry point of your program
    !
    !***********************************************************
    PROC main()
        !Add your code here
        MoveAbsJ JointTarget_1,v1000,z100,tool0\WObj:=wobj0;
        Path_10;
        MoveAbsJ JointTarget_1,v1000,fine,tool0\WObj:=wobj0;
    ENDPROC
    PROC Path_10()
        MoveJ Target_10,v1000,z100,AW_Gun\WObj:=Workobject_1;
        MoveL Target_20,v200,fine,AW_Gun\WObj:=Workobject_1;
        MoveLDO Target_30,v100,z1,AW_Gun\WObj:=Workobject_1,do_process,1;
        MoveC Target_40,Target_50,v100,z1,AW_Gun\WObj:=Workobject_1;
        MoveLDO Target_60,v100,fine,AW_Gun\WObj:=Workobject_1,do_process,0;
        MoveL Offs(Target_60,0,0,120),v500,z100,AW_Gun\WObj:=Workobject_1;
    ENDPROC
ENDMODULE
