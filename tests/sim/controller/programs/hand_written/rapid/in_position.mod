MODULE InPosition
  ! Dispense in four dots; the needle must stand still before the valve opens, hence \InPos everywhere
  PERS tooldata tNeedle:=[TRUE,[[0,0,98.7],[1,0,0,0]],[0.9,[0,0,40],[1,0,0,0],0,0,0]];
  PERS loaddata ldFull:=[0.9,[0,0,40],[1,0,0,0],0,0,0];
  TASK PERS wobjdata wPcb:=[FALSE,TRUE,"",[[450,0,15],[1,0,0,0]],[[0,0,1.6],[1,0,0,0]]];
  CONST robtarget pDot:=[[5,5,0.2],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST jointtarget jWait:=[[-45,10,15,0,65,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

  PROC main()
    GripLoad ldFull;
    MoveAbsJ jWait, vmax, z50, tNeedle;
    MoveJ Offs(pDot,0,0,20), vmax, z5, tNeedle\WObj:=wPcb;
    MoveL pDot, v50, fine, tNeedle\WObj:=wPcb;
    drop;
    MoveL Offs(pDot,12.7,0,0), v50, fine, tNeedle\WObj:=wPcb;
    drop;
    MoveL Offs(pDot,12.7,7.62,0), v50, fine, tNeedle\WObj:=wPcb;
    drop;
    MoveL Offs(pDot,0,7.62,0), v50, fine, tNeedle\WObj:=wPcb;
    drop;
    MoveL Offs(pDot,0,7.62,20), v200, fine, tNeedle\WObj:=wPcb;
  ENDPROC

  PROC drop()
    WaitTime \InPos, 0.05;
    PulseDO \High \PLength:=0.12, doValve;
    WaitTime\InPos,0.15;
  ENDPROC
ENDMODULE
