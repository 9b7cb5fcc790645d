MODULE LocalNames
  ! everybody calls his first point p10: each routine has its own
  CONST robtarget p10 := [[500,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST speeddata vCut := [30,500,5000,1000];
  PERS tooldata tCut := [TRUE,[[0,0,130],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];

  PROC main()
    MoveJ p10, v500, fine, tCut;      ! the module's p10
    left;
    MoveL p10, v100, fine, tCut;      ! the module's again
    right;
    MoveL p10, vCut, fine, tCut;      ! and again, at 30 mm/s
  ENDPROC

  PROC left()
    CONST robtarget p10 := [[520,80,280],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget p20 := [[560,80,280],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    MoveL p10, v100, fine, tCut;
    common;
    MoveL p20, vCut, z1, tCut;
    MoveL Offs(p20,0,20,0), vCut, fine, tCut;
  ENDPROC

  PROC right()
    CONST speeddata vCut := [12,500,5000,1000];
    CONST robtarget p20 := [[560,-80,280],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    MoveL p20, vCut, fine, tCut;
    common;
  ENDPROC

  PROC common()
    MoveL Offs(p10,0,0,5), vCut, z5, tCut;   ! p10 and vCut of the module, whoever calls
  ENDPROC
ENDMODULE
