%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%
MODULE WJ_Gasket
  ! history
  ! 2019-03-02  first cut, EPDM 5 mm
  ! 2019-03-09  pierce 1.2 s instead of 0.8 s (the pump: 2800 bar)
  ! 2021-11-30  robot exchanged; "pZero" taught again
  CONST num nPierce := 1.2;
  PERS tooldata tWJ := [TRUE,[[3,0,221],[1,0,0,0]],[7,[0,0,100],[1,0,0,0],0,0,0]];
  PERS wobjdata wTank := [FALSE,TRUE,"",[[1500,0,-50],[1,0,0,0]],[[-5,12.5,0],[0.9999619,0,0,0.0087265]]];
  CONST robtarget pZero := [[0,0,2],[0,0,1,0],[0,-1,1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

  PROC main()
    TPErase;
    TPWrite "Gasket 17-B";
    SetGO goPump, 5;
    WaitTime 3;
    MoveJ Offs(pZero,0,0,25), v600, z10, tWJ\WObj:=wTank;
    MoveL pZero, v100, fine, tWJ\WObj:=wTank;
    SetDO doJet, 1;
    WaitTime 1.2;
    MoveL Offs(pZero,5,0,0), v20, z5, tWJ\WObj:=wTank;
    MoveL Offs(pZero,45,0,0), v40, z5, tWJ\WObj:=wTank;
    MoveL Offs(pZero,50,5,0), v40, z5, tWJ\WObj:=wTank;
    MoveL Offs(pZero,50,30,0), v30, z5, tWJ\WObj:=wTank;
    MoveL Offs(pZero,0,30,0), v30, fine, tWJ\WObj:=wTank;
    SetDO \SDelay:=0.2, doJet, 0;
    WaitTime .3;
    SetGO goPump, 0;
    MoveL Offs(pZero,0,30,25), v100, fine, tWJ\WObj:=wTank;
  ENDPROC
ENDMODULE
