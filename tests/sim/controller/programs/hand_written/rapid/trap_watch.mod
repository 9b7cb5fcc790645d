MODULE Watch
  VAR intnum iDoor;
  CONST robtarget pW:=[[550,0,350],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  ! the door is watched while the arm moves
  TRAP tDoor
    StopMove;
    TPWrite "door!";
  ENDTRAP
  PROC main()
    CONNECT iDoor WITH tDoor;
    ISignalDI diDoor,0,iDoor;
    MoveJ pW,v300,fine,tool0;
    MoveL Offs(pW,50,0,0),v50,fine,tool0;
    IDelete iDoor;
  ENDPROC
ENDMODULE
