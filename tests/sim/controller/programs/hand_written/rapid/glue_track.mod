MODULE GlueTrack
! Sealing bead along a 6 m side wall, arm on a linear track (first external axis, mm).
! The track stands still while the bead is laid and moves between stations only.
CONST extjoint ST1:=[500,9E9,9E9,9E9,9E9,9E9];
CONST extjoint ST2:=[2.75E3,9E9,9E9,9E9,9E9,9E9];
CONST confdata cf:=[0,0,0,0];
CONST orient oDown:=[0,0.7071068,0.7071068,0];
CONST jointtarget jPark:=[[90,0,0,0,45,0],[0,9E9,9E9,9E9,9E9,9E9]];
PERS tooldata tNozzle:=[TRUE,[[0,80,240],[0.8660254,0.5,0,0]],[8,[0,30,110],[1,0,0,0],0,0,0]];
TASK PERS wobjdata wWall:=[FALSE,TRUE,"",[[0,1400,200],[0.7071068,0,0,0.7071068]],[[0,0,0],[1,0,0,0]]];
CONST robtarget a1:=[[600,0,150],oDown,cf,ST1];
CONST robtarget a2:=[[640,0,150],oDown,cf,ST1];
CONST robtarget a3:=[[680,3.5,150],oDown,cf,ST1];
CONST robtarget b1:=[[2850,0,150],oDown,cf,ST2];
CONST robtarget b2:=[[2895,0,150],oDown,cf,ST2];
CONST speeddata vBead:=[120,200,800,1000];
PROC main()
  MoveAbsJ jPark\NoEOffs,v500,fine,tNozzle;
  station1;
  station2;
  MoveAbsJ jPark\NoEOffs,v500,fine,tNozzle;
ENDPROC
PROC station1()
  MoveJ Offs(a1,0,0,60),v500,z10,tNozzle\WObj:=wWall;
  MoveL a1,v100,fine,tNozzle\WObj:=wWall;
  Set doGlue;
  MoveL a2,vBead,z10,tNozzle\WObj:=wWall;
  MoveL a3,vBead,fine,tNozzle\WObj:=wWall;
  Reset doGlue;
ENDPROC
PROC station2()
  MoveJ Offs(b1,0,0,60),v500,z10,tNozzle\WObj:=wWall;
  MoveL b1,v100,fine,tNozzle\WObj:=wWall;
  Set doGlue;
  MoveL b2,vBead,fine,tNozzle\WObj:=wWall;
  Reset doGlue;
ENDPROC
ENDMODULE
