MODULE Variant
  ! two variants of the same cover: with and without the slot
  CONST robtarget pS:=[[500,0,200],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveJ pS,v300,fine,tool0;
    rim;
  ENDPROC
  PROC rim()
    MoveL Offs(pS,100,0,0),v50,z1,tool0;
    MoveL Offs(pS,100,50,0),v50,fine,tool0;
    IF diSlot=1 THEN
      MoveL Offs(pS,60,50,0),v50,fine,tool0;
    ELSE
      MoveL Offs(pS,0,50,0),v50,fine,tool0;
    ENDIF
    MoveL pS,v50,fine,tool0;
  ENDPROC
ENDMODULE
