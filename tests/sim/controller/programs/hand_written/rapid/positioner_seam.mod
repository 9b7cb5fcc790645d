MODULE Seam_L4(SYSMODULE, NOSTEPIN)
  ! Two seams on a bracket that is clamped on a turntable (unit STN1).
  ! The frame of wobjSTN1 is moved by the table: its user frame is NOT here but in the system parameters.
  PERS tooldata tTorch := [TRUE, [[-5.2,0,388.4],[0.9238795,0,0.3826834,0]], [4.2,[0,0,140],[1,0,0,0],0,0,0]];
  PERS wobjdata wobjSTN1 := [FALSE, FALSE, "STN1", [[0,0,0],[1,0,0,0]], [[0,0,87],[1,0,0,0]]];
  CONST robtarget pAir   := [[-40, 0,120],[0,0.9238795,0.3826834,0],[0,-1,-1,0],[ 45,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pSeam1 := [[  0, 0,  0],[0,0.9238795,0.3826834,0],[0,-1,-1,0],[ 45,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pSeam2 := [[ 70, 0,  0],[0,0.9238795,0.3826834,0],[0,-1,-1,0],[ 45,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pSeam3 := [[ 70,55,  0],[0,0.9238795,0.3826834,0],[0,-1,-1,0],[ 45,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pBack  := [[  0,55,  0],[0,0.9238795,0.3826834,0],[0,-1,-1,0],[-45,9E9,9E9,9E9,9E9,9E9]];
  CONST speeddata vWeld  := [9.5, 200, 500, 30];

  PROC main()
    ActUnit STN1;
    MoveJ pAir, v300, fine, tTorch\WObj:=wobjSTN1;
    MoveL pSeam1, v100, fine, tTorch\WObj:=wobjSTN1;
    SetDO doArc, 1; WaitTime 0.25;
    MoveL pSeam2, vWeld, z5, tTorch\WObj:=wobjSTN1;
    MoveL pSeam3, vWeld, fine, tTorch\WObj:=wobjSTN1;
    SetDO doArc, 0; WaitTime 0.5;
    MoveJ pBack, v300, fine, tTorch\WObj:=wobjSTN1;
    DeactUnit STN1;
  ENDPROC
ENDMODULE
