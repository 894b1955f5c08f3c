MODULE TendLathe
    !----------------------------------------------------------------
    ! Machine tending: raw part from infeed, lathe, finished part out
    !----------------------------------------------------------------
    PERS tooldata tGrip:=[TRUE,[[0,0,210],[1,0,0,0]],[5.1,[0,0,95],[1,0,0,0],0.05,0.05,0.02]];
    CONST robtarget pHome:=[[1250,0,900],[0,0,1,0],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget pInfeed:=[[1300,-450,550],[0,0,1,0],[-1,0,-1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget pOutfeed:=[[1300,450,550],[0,0,1,0],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget pChuck:=[[1500,0,700],[0,0,1,0],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    PERS loaddata ldRaw:=[2.4,[0,0,40],[1,0,0,0],0,0,0];
    VAR clock ckCycle;
    VAR bool bTimeout;
    VAR errnum ERR_NO_PART:=-1;
    VAR intnum iDoor;

    PROC main()
        Init;
        WHILE TRUE DO
            ClkReset ckCycle;
            ClkStart ckCycle;
            IF DInput(diLatheReady)=0 THEN
                TPWrite "Waiting for lathe";
                WaitDI diLatheReady,1;
            ENDIF
            PickPart pInfeed;
            LoadLathe;
            IF diUnload=1 AND NOT bTimeout THEN
                PickPart pChuck\Dist:=120;
                PutPart pOutfeed;
            ENDIF
            ClkStop ckCycle;
            TPWrite "Cycle time "\Num:=ClkRead(ckCycle);
            IF doStopAfter=1 Stop;
        ENDWHILE
    ENDPROC

    PROC Init()
        BookErrNo ERR_NO_PART;
        TPErase;
        AccSet 80,70;
        VelSet 100,2000;
        MotionSup\On\TuneValue:=150;
        Set doGripOpen;
        MoveJ pHome,v1000,fine,tGrip;
        WaitRob\InPos;
    ENDPROC

    PROC PickPart(robtarget pPart\num Dist)
        VAR num nDist:=80;
        IF Present(Dist) nDist:=Dist;
        MoveJ Offs(pPart,0,0,nDist),v1500,z50,tGrip\WObj:=wobj0;
        MoveL pPart,v300,fine,tGrip\WObj:=wobj0;
        Grip\Close;
        IF DOutput(doGripClose)=0 THEN
            RAISE ERR_NO_PART;
        ENDIF
        GripLoad ldRaw;
        MoveL Offs(pPart,0,0,nDist),v500,z20,tGrip\WObj:=wobj0;
    ERROR
        IF ERRNO=ERR_NO_PART THEN
            TPWrite "No part in gripper";
            RETRY;
        ELSEIF ERRNO=ERR_WAIT_MAXTIME THEN
            RAISE;
        ENDIF
    ENDPROC

    PROC PutPart(robtarget pPart)
        MoveJ Offs(pPart,0,0,100),v1500,z50,tGrip;
        MoveL pPart,v200,fine,tGrip;
        Grip\Open;
        MoveL Offs(pPart,0,0,100),v500,z50,tGrip;
    ENDPROC

    PROC LoadLathe()
        WaitUntil diDoorOpen=1 AND diChuckOpen=1\MaxTime:=60\TimeFlag:=bTimeout;
        MoveJ Offs(pChuck,-200,0,0),v1000,z20,tGrip;
        MoveL pChuck,v150,fine,tGrip;
        PulseDO\PLength:=0.2,doChuckClose;
        WaitDI diChuckClosed,1\MaxTime:=5;
        Grip\Open;
        MoveL Offs(pChuck,-200,0,0),v500,z20,tGrip;
        MoveJ pHome,v1000,z100,tGrip;
        SetDO\SDelay:=0.2,doLatheStart,1;
    ENDPROC

    LOCAL PROC Grip(\switch Open|switch Close)
        IF Present(Open) THEN
            Reset doGripClose;
            Set doGripOpen;
        ELSE
            Reset doGripOpen;
            Set doGripClose;
        ENDIF
        WaitTime\InPos,0.25;
    ENDPROC
ENDMODULE
