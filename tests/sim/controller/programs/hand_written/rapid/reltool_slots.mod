MODULE Slots
  ! inclined slots: the approach is along the tool, so it is RelTool and not Offs
  CONST robtarget pSlot:=[[640,-30,410],[0.9238795,0,0.3826834,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS tooldata tSlit:=[TRUE,[[0,0,160],[1,0,0,0]],[2,[0,0,60],[1,0,0,0],0,0,0]];
  PROC main()
    MoveJ Offs(pSlot,0,0,100),v500,z10,tSlit;
    MoveL RelTool(pSlot,0,0,-15),v100,fine,tSlit;
    MoveL pSlot,v40,fine,tSlit;
    MoveL RelTool(pSlot,0,12,0),v40,fine,tSlit;
    MoveL RelTool(pSlot,0,12,-15),v100,fine,tSlit;
    ! the second slot is turned about the tool by 30 degrees
    MoveL RelTool(pSlot,25,0,-15\Rz:=30),v100,fine,tSlit;
    MoveL RelTool(pSlot,25,0,0\Rz:=30),v40,fine,tSlit;
    MoveJ Offs(pSlot,0,0,100),v500,z10,tSlit;
  ENDPROC
ENDMODULE
