MODULE NamedHeights
  ! one place for what changes from sheet to sheet: "n..." are numbers, nothing is computed
  CONST num nSafe := 25;
  CONST num nPierce := 0.35;
  PERS num nStandoff := -1.5;
  CONST robtarget pCorner := [[100,50,2],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

  PROC main()
    MoveJ Offs(pCorner, 0, 0, nSafe), v200, z10, tNozzle\WObj:=wSheet;
    MoveL Offs(pCorner,0,0,nStandoff), v50, fine, tNozzle\WObj:=wSheet;
    SetDO doBeam, 1;
    WaitTime nPierce;
    MoveL Offs(pCorner,12,0,nStandoff), v30, z1, tNozzle\WObj:=wSheet;
    MoveL Offs(pCorner,12,9,nStandoff), v30, fine, tNozzle\WObj:=wSheet;
    SetDO doBeam, 0;
    MoveL Offs(pCorner,12,9,nSafe), v200, fine, tNozzle\WObj:=wSheet;
  ENDPROC
ENDMODULE
