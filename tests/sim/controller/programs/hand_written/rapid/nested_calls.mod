MODULE Nested
  PERS wobjdata wNet:=[FALSE,TRUE,"",[[600,0,0],[1,0,0,0]],[[0,0,10],[1,0,0,0]]];
  PERS tooldata tNet:=[TRUE,[[0,0,50],[1,0,0,0]],[1,[0,0,25],[1,0,0,0],0,0,0]];
  CONST robtarget pTop:=[[0,0,50],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget p1:=[[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget p2:=[[25,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget p3:=[[25,25,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget p4:=[[0,25,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

  PROC main()
    ! warm up without beam, then twice with it
    once; twice;
  ENDPROC

  PROC twice()
    once;
    once;
  ENDPROC

  PROC once()
    MoveJ pTop, v300, z5, tNet\WObj:=wNet;
    square;
  ENDPROC

  PROC square()
    MoveL p1, v50, fine, tNet\WObj:=wNet;
    side_a;
    side_b;
  ENDPROC

  PROC side_a()
    MoveL p2, v50, z1, tNet\WObj:=wNet;
    MoveL p3, v50, z1, tNet\WObj:=wNet;
  ENDPROC

  PROC side_b()
    MoveL p4, v50, z1, tNet\WObj:=wNet;
    MoveL p1, v50, fine, tNet\WObj:=wNet;
  ENDPROC

  PROC service()   ! by hand only, nobody calls it: the robot goes to its park position
    MoveAbsJ [[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v200, fine, tNet;
  ENDPROC
ENDMODULE
