MODULE Palletise
    !=====================================================
    ! Palletising cartons 200 x 150 x 120, 2 x 3 per layer
    ! Layer pattern by table, approach from above
    !=====================================================
    CONST num NO_OF_LAYERS := 2;
    CONST num PER_LAYER := 3;
    CONST num BOX_H := 120;
    ! x, y, turn of each box in a layer
    CONST num nPattern{3,3} := [[0, 0, 0], [200, 0, 0], [100, 175, 90]];
    CONST robtarget pPick := [[1250, -450, 650], [0, 0, 1, 0], [-1, 0, -1, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
    CONST robtarget pPallet := [[1300, 100, 450], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
    PERS tooldata tVacuum := [TRUE, [[0, 0, 180], [1, 0, 0, 0]], [12, [0, 0, 90], [1, 0, 0, 0], 0.2, 0.2, 0.1]];
    PERS loaddata ldBox := [6.5, [0, 0, 60], [1, 0, 0, 0], 0, 0, 0];
    PERS num nBoxes := 0;
    VAR robtarget pPlaced{6};

    PROC main()
        VAR num nIndex;
        ConfJ \Off;
        ConfL \Off;
        VelSet 80, 1500;
        nBoxes := 0;
        WHILE nBoxes < NO_OF_LAYERS * PER_LAYER DO
            nIndex := nBoxes MOD PER_LAYER + 1;
            Pick;
            Place BoxTarget(nIndex, nBoxes DIV PER_LAYER);
            pPlaced{nBoxes + 1} := CRobT(\Tool:=tVacuum \WObj:=wobj0);
            Incr nBoxes;
        ENDWHILE
        IF nBoxes <> Dim(pPlaced, 1) THEN
            TPWrite "Pallet not full: " + NumToStr(nBoxes, 0);
            EXIT;
        ENDIF
        MoveJ Offs(pPick, 0, 0, 300), v1500, fine, tVacuum;
        SetDO doPalletFull, 1;
    ENDPROC

    FUNC robtarget BoxTarget(num nBox, num nLayer)
        VAR robtarget pBox;
        pBox := Offs(pPallet, nPattern{nBox, 1}, nPattern{nBox, 2}, nLayer * BOX_H);
        RETURN RelTool(pBox, 0, 0, 0 \Rz:=nPattern{nBox, 3});
    ENDFUNC

    PROC Pick()
        MoveJ Offs(pPick, 0, 0, 250), v2000, z50, tVacuum;
        WaitDI diBoxReady, 1;
        MoveL pPick, v500, fine, tVacuum;
        Set doVacuum;
        WaitUntil DInput(diVacuumOk) = 1 \MaxTime:=2;
        GripLoad ldBox;
        MoveL Offs(pPick, 0, 0, 250), v1000, z50, tVacuum;
    ENDPROC

    PROC Place(robtarget pTarget)
        MoveJ Offs(pTarget, 0, 0, 250), v2000, z50, tVacuum;
        MoveL Offs(pTarget, 0, 0, 20), v800, z5, tVacuum;
        MoveL pTarget, v100, fine, tVacuum;
        Reset doVacuum;
        WaitTime 0.3;
        GripLoad load0;
        MoveL Offs(pTarget, 0, 0, 250), v1000, z50, tVacuum;
    ENDPROC
ENDMODULE
