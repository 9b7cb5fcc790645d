MODULE Messages
  ! Операторам: не трогать! 操作员：请勿更改。 L'opérateur: "ne pas toucher" !
  VAR num nPart:=0;
  CONST string stName:="Seitenteil ""links"" [neu]";
  CONST robtarget pS:=[[700,100,450],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS tooldata tSchweisskopf:=[TRUE,[[0,0,212],[1,0,0,0]],[3,[0,0,90],[1,0,0,0],0,0,0]];
  PROC main()
    TPErase;
    TPWrite "=== ENDPROC ENDMODULE === ! no comment";
    TPWrite "Teil: "+stName;
    TPWrite "Nr. "\Num:=nPart;
    MoveJ pS,v500,z50,tSchweisskopf;
    TPWrite "C:\\temp\\log ; MoveL pS,v5,fine,tool0;";
    MoveL Offs(pS,0,0,-50),v100,fine,tSchweisskopf; TPWrite "Düse ""unten""";
    SetDO doGas,1; TPWrite ""; SetDO doBeam,1;
    MoveL Offs(pS,30,0,-50),v30,z5,tSchweisskopf;
    MoveL Offs(pS,60,0,-49.5),v30,fine,tSchweisskopf;
    Reset doBeam; Reset doGas;
    TPWrite "°C, µm, ½, €: alles gut";
    MoveL pS,v500,fine,tSchweisskopf;
  ENDPROC
ENDMODULE
