MODULE Längsträger
  ! namn på svenska och tyska: ett par åäö gör ingen skada
  PERS tooldata tSkärhuvud:=[TRUE,[[0,0,144],[1,0,0,0]],[2,[0,0,60],[1,0,0,0],0,0,0]];
  PERS wobjdata wTräger:=[FALSE,TRUE,"",[[1300,-200,600],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  CONST robtarget pÖverst:=[[0,0,75],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pStart_Ø8:=[[4,0,0],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST speeddata vTrägheten:=[18,500,5000,1000];
  PROC main()
    MoveJ pÖverst,v500,z5,tSkärhuvud\WObj:=wTräger;
    Ausschnitt_groß;
    MoveL pöverst,v500,fine,tSKÄRHUVUD\WObj:=wTRÄGER;
  ENDPROC
  PROC Ausschnitt_groß()
    MoveL pStart_Ø8,v100,fine,tSkärhuvud\WObj:=wTräger;
    SetDO doTändning,1;
    WaitTime 0.6;
    MoveC Offs(pStart_ø8,-4,4,0),Offs(pStart_Ø8,-8,0,0),vTrägheten,z1,tSkärhuvud\WObj:=wTräger;
    MoveC Offs(pStart_ø8,-4,-4,0),pStart_Ø8,vTrägheten,fine,tSkärhuvud\WObj:=wTräger;
    SetDO doTändning,0;
  ENDPROC
ENDMODULE
