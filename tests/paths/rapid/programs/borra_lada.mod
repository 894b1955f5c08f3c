MODULE BorraLada(NOSTEPIN)
  ! Borrning av hålmönster i låda, två sidor
  ! Ändrad 2019-03-12 av Åke: matning sänkt för rostfritt
  LOCAL CONST num Säkerhetshöjd:=40;
  LOCAL CONST num nHål:=5;
  PERS tooldata tBorr:=[TRUE,[[0,0,190],[1,0,0,0]],[7,[0,0,100],[1,0,0,0],0,0,0]];
  PERS wobjdata wLåda:=[FALSE,TRUE,"",[[1300,-300,500],[1,0,0,0]],[[0,0,50],[1,0,0,0]]];
  LOCAL CONST robtarget pHörn:=[[0,0,0],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL VAR num nBorrade:=0;
  LOCAL VAR speeddata vMatning:=[8,500,5000,1000];

  PROC main()
    ConfJ\Off;
    SpindelPå 3000;
    FOR i FROM 1 TO nHål DO
      Borra Offs(pHörn,25*i,20,0),12,nBorrade;
    ENDFOR
    ! andra raden baklänges, genomgående med brotsch
    FOR i FROM nHål TO 1 STEP -2 DO
      Borra Offs(pHörn,25*i,60,0),18,nBorrade\Urspåna\Matning:=vMatning;
    ENDFOR
    TPWrite "Antal hål: "\Num:=nBorrade;
    SpindelPå 0;
  ENDPROC

  LOCAL PROC SpindelPå(num varv)
    SetGO goVarvtal,varv DIV 10;
    SetDO doSpindel,1;
    IF varv=0 SetDO doSpindel,0;
    WaitTime 0.5;
  ENDPROC

  ! Borrar ett hål; \Urspåna lyfter borren halvvägs
  LOCAL PROC Borra(robtarget pHål,num djup,INOUT num antal\switch Urspåna\speeddata Matning)
    VAR speeddata v;
    IF Present(Matning) THEN
      v:=Matning;
    ELSE
      v:=[15,500,5000,1000];
    ENDIF
    MoveJ Offs(pHål,0,0,Säkerhetshöjd),v1000,z10,tBorr\WObj:=wLåda;
    MoveL Offs(pHål,0,0,2),v200,fine,tBorr\WObj:=wLåda;
    IF Present(Urspåna) THEN
      MoveL Offs(pHål,0,0,-djup/2),v,fine,tBorr\WObj:=wLåda;
      MoveL Offs(pHål,0,0,2),v100,fine,tBorr\WObj:=wLåda;
    ENDIF
    MoveL Offs(pHål,0,0,-djup),v,fine,tBorr\WObj:=wLåda;
    MoveL Offs(pHål,0,0,Säkerhetshöjd),v200,z10,tBorr\WObj:=wLåda;
    antal:=antal+1;
  ENDPROC
ENDMODULE
