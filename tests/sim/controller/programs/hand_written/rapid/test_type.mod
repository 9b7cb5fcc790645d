MODULE TypeSelect
  VAR num nType:=2;
  CONST robtarget pBase:=[[520,20,180],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  ! the PLC writes the type into giType
  PROC main()
    MoveJ pBase,v500,fine,tool0;
    TEST nType
    CASE 1:
      small;
    CASE 2,3:
      large;
    DEFAULT:
      TPWrite "unknown type";
    ENDTEST
  ENDPROC
  PROC small()
    MoveL Offs(pBase,10,0,0),v50,fine,tool0;
  ENDPROC
  PROC large()
    MoveL Offs(pBase,30,0,0),v50,fine,tool0;
  ENDPROC
ENDMODULE
