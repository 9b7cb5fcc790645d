%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%
MODULE Part_2207(READONLY)
  ! Called from the cell's own main by its name: Part_2207.  Do not add a main here!
  ! The steps come first and the part itself last, as in all our part modules.
  CONST robtarget pIn:=[[0,0,40],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pK1:=[[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pK2:=[[30,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pK3:=[[30,18,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pK4:=[[0,18,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

  LOCAL PROC approach()
    MoveJ pIn,v500,z10,tCell\WObj:=wFixture3;
    MoveL pK1,v100,fine,tCell\WObj:=wFixture3;
  ENDPROC

  LOCAL PROC contour()
    MoveL pK2,v40,z5,tCell\WObj:=wFixture3;
    MoveL pK3,v40,z5,tCell\WObj:=wFixture3;
    MoveL pK4,v40,z5,tCell\WObj:=wFixture3;
    MoveL pK1,v40,fine,tCell\WObj:=wFixture3;
  ENDPROC

  PROC Part_2207()
    approach;
    SetDO doLaser,1;
    contour;
    SetDO doLaser,0;
    MoveL pIn,v200,fine,tCell\WObj:=wFixture3;
  ENDPROC
ENDMODULE
