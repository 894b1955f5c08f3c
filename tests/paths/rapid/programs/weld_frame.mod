%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%

MODULE Rahmen
  ! Schweißprogramm Rahmen links, Kehlnaht a4
  ! Werkzeug: Brenner 22 Grad, Drahtende 15 mm
  ! geändert: Müller, Schweißgeschwindigkeit erhöht
  PERS tooldata tBrenner:=[TRUE,[[60,0,330],[0.9238795,0,0.3826834,0]],[4.2,[20,0,110],[1,0,0,0],0,0,0]];
  PERS wobjdata wVorrichtung:=[FALSE,TRUE,"",[[1350,-250,550],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  PERS seamdata smA4:=[0.5,0.3,[0,0,0,0,0,0,0,0,0],0,0,0,0,0,[0,0,0,0,0,0,0,0,0],0,0,[0,0,0,0,0,0,0,0,0],0,0.4,[0,0,0,0,0,0,0,0,0]];
  PERS welddata wdA4:=[9,0,[0,0,22.5,0,0,0,0,0,0],[0,0,0,0,0,0,0,0,0]];
  PERS weavedata wvKein:=[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0];
  CONST robtarget pAnfahrt:=[[0,0,150],[0,0.3826834,0.9238795,0],[-1,-1,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  CONST robtarget pNaht1A:=[[0,0,5],[0,0.3826834,0.9238795,0],[-1,-1,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  CONST robtarget pNaht1M:=[[60,0,5],[0,0.3826834,0.9238795,0],[-1,-1,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  CONST robtarget pNaht1E:=[[120,40,5],[0,0.3826834,0.9238795,0],[-1,-1,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  VAR num nTeile:=0;
  VAR bool bStoerung:=FALSE;

  PROC main()
    ! Grundstellung, danach Dauerbetrieb
    Grundstellung;
    WHILE TRUE DO
      WaitDI diStart,1;
      IF bStoerung=TRUE THEN
        TPWrite "Störung quittieren";
        Stop;
      ENDIF
      NahtSchweissen;
      nTeile:=nTeile+1;
      TPWrite "Teile: "\Num:=nTeile;
      PulseDO\PLength:=0.5,doFertig;
    ENDWHILE
  ENDPROC

  PROC Grundstellung()
    ConfL\Off;
    Reset doFertig;
    MoveJ pAnfahrt,v500,fine,tBrenner\WObj:=wVorrichtung;
  ENDPROC

  LOCAL PROC NahtSchweissen()
    MoveL Offs(pNaht1A,0,0,40),v300,z10,tBrenner\WObj:=wVorrichtung;
    ArcLStart pNaht1A,v200,smA4,wdA4\Weave:=wvKein,fine,tBrenner\WObj:=wVorrichtung;
    ArcL pNaht1M,v200,smA4,wdA4\Weave:=wvKein,z5,tBrenner\WObj:=wVorrichtung;
    ArcCEnd Offs(pNaht1M,45,15,0),pNaht1E,v200,smA4,wdA4\Weave:=wvKein,fine,tBrenner\WObj:=wVorrichtung;
    MoveL Offs(pNaht1E,0,0,60),v500,z20,tBrenner\WObj:=wVorrichtung;
    MoveJ pAnfahrt,v500,fine,tBrenner\WObj:=wVorrichtung;
  ENDPROC
ENDMODULE
