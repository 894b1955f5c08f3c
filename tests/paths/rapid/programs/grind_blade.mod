MODULE GrindBlade
    ! Belt grinding of a blade edge: arc-shaped strokes with a lead angle, until the stock is gone.
    RECORD stroke
        num depth;
        num lead;
        speeddata v;
    ENDRECORD

    CONST num R_EDGE:=90;
    CONST num N_POINTS:=6;
    PERS tooldata tDisc:=[TRUE,[[0,0,260],[1,0,0,0]],[6,[0,0,130],[1,0,0,0],0,0,0]];
    PERS wobjdata wBlade:=[FALSE,TRUE,"",[[1350,-100,600],[0.9238795325,0,0,0.3826834324]],[[0,0,0],[1,0,0,0]]];
    CONST robtarget pEdge:=[[0,0,0],[0,0.3826834324,0.9238795325,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    VAR stroke stRough:=[0.4,8,[120,200,5000,1000]];
    VAR stroke stFinish:=[0.05,3,[60,200,5000,1000]];

    PROC main()
        VAR num nStock:=1;
        VAR num nStrokes;
        SingArea \Wrist;
        ConfL \Off;
        ConfJ \Off;
        SetAO aoBelt, 18.5;
        MoveJ Offs(EdgePoint(0,0,0),0,0,80),v500,fine,tDisc\WObj:=wBlade;
        WHILE nStock>stFinish.depth AND nStrokes<10 DO
            IF nStock>2*stRough.depth THEN
                Grind stRough,nStock;
            ELSE
                Grind stFinish,nStock;
                nStock:=Round(nStock/2\Dec:=2);
            ENDIF
            nStrokes:=nStrokes+1;
        ENDWHILE
        TPWrite "Strokes: "+ValToStr(nStrokes);
        SetAO aoBelt,0;
    ENDPROC

    PROC Grind(stroke s,INOUT num nStock)
        VAR num a;
        nStock:=nStock-s.depth;
        IF nStock<0 nStock:=0;
        MoveL Offs(EdgePoint(-30,nStock,s.lead),0,0,20),v200,z5,tDisc\WObj:=wBlade;
        FOR i FROM 0 TO N_POINTS DO
            a:=-30+60*i/N_POINTS;
            IF i=0 OR i=N_POINTS THEN
                MoveL EdgePoint(a,nStock,s.lead),s.v,fine,tDisc\WObj:=wBlade;
            ELSE
                MoveL EdgePoint(a,nStock,s.lead),s.v,z1,tDisc\WObj:=wBlade;
            ENDIF
        ENDFOR
        MoveL RelTool(CRobT(\Tool:=tDisc\WObj:=wBlade),0,0,-40),v200,z5,tDisc\WObj:=wBlade;
    ENDPROC

    ! Point of the edge at an angle, raised by the stock that is left, disc tilted by the lead angle
    FUNC robtarget EdgePoint(num angle,num stock,num lead)
        VAR robtarget p;
        VAR pos vec;
        vec:=[R_EDGE*Sin(angle),R_EDGE*Cos(angle)-R_EDGE,stock];
        p:=pEdge;
        p.trans:=p.trans+vec;
        RETURN RelTool(p,0,0,0\Ry:=lead);
    ENDFUNC
ENDMODULE
