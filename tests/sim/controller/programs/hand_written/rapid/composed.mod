MODULE Composed(NOVIEW)
  ! positions put together from their parts, as our old editor exported them
  CONST pos xyzA := [12.5,-8.25,0];
  CONST pos xyzB := [37.5,-8.25,0];
  CONST orient rDown := [0,1,0,0];
  CONST confdata cfgFront := [0,-1,0,0];
  CONST extjoint noExt := [9E9,9E9,9E9,9E9,9E9,9E9];
  CONST robtarget A := [xyzA,rDown,cfgFront,noExt];
  CONST robtarget B := [xyzB,rDown,cfgFront,noExt];
  CONST robtarget Bagain := B;
  CONST robjoint rHome := [10,-15,20,0,85,-10];
  CONST jointtarget Home := [rHome,noExt];
  CONST loaddata ldGun := [2.4,[0,0,60],[1,0,0,0],0,0,0];
  PERS tooldata tGun := [TRUE,[[0,0,155.5],[1,0,0,0]],[2.4,[0,0,60],[1,0,0,0],0,0,0]];
  PERS wobjdata wTable := [FALSE,TRUE,"",[[820,-40,350],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];

  PROC main()
    MoveAbsJ Home, v300, fine, tGun;
    MoveJ Offs(A,0,0,10), v300, z5, tGun\TLoad:=ldGun\WObj:=wTable;
    MoveL A, v80, fine, tGun\TLoad:=ldGun\WObj:=wTable;
    MoveL [[25,-8.25,0.125],rDown,cfgFront,noExt], v10, z5, tGun\TLoad:=ldGun\WObj:=wTable;
    MoveL Bagain, v10, fine, tGun\TLoad:=ldGun\WObj:=wTable;
    MoveL Offs(B,0,0,10), v80, fine, tGun\TLoad:=ldGun\WObj:=wTable;
    MoveAbsJ Home\NoEOffs, v300, fine, tGun;
  ENDPROC
ENDMODULE
