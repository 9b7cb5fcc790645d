MODULE CutAndMark
! ---------------------------------------------------------------------------
! cell 4      laser cutting and dot marking of the same plate in two fixtures
! rev  date        who   what
! A    14.01.2020  kb    first
! B    02.06.2020  kb    second fixture (wFixB), turned by 90 degrees
! C    19.11.2022  mt    marker offset measured again: 0.35 mm in x
! ---------------------------------------------------------------------------
PERS tooldata tCut:=[TRUE,[[0,0,180],[1,0,0,0]],[4,[0,0,80],[1,0,0,0],0,0,0]];
PERS tooldata tMark:=[TRUE,[[90.35,0,120],[0.9659258,0,0.2588190,0]],[4,[0,0,80],[1,0,0,0],0,0,0]];
PERS wobjdata wFixA:=[FALSE,TRUE,"",[[700,300,200],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
PERS wobjdata wFixB:=[FALSE,TRUE,"",[[700,-300,200],[0.7071068,0,0,-0.7071068]],[[0,0,0],[1,0,0,0]]];
CONST robtarget k1:=[[20,20,0],[0,0,1,0],[0,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget k2:=[[80,20,0],[0,0,1,0],[0,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget m1:=[[50,-5.5,1],[0,0,1,0],[0,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

PROC main()
  fixture_A;
  fixture_B;
ENDPROC

PROC fixture_A()
  MoveJ Offs(k1,0,0,30),v800,z20,tCut\WObj:=wFixA;
  MoveL k1,v80,fine,tCut\WObj:=wFixA;
  SetDO doLaser,1;
  MoveL k2,v40,fine,tCut\WObj:=wFixA;
  SetDO doLaser,0;
  MoveJ Offs(m1,0,0,30),v800,z20,tMark\WObj:=wFixA;
  MoveL m1,v80,fine,tMark\WObj:=wFixA;
  dot;
ENDPROC

PROC fixture_B()
  ! the same points in the other fixture
  MoveJ Offs(k1,0,0,30),v800,z20,tCut\WObj:=wFixB;
  MoveL k1,v80,fine,tCut\WObj:=wFixB;
  SetDO doLaser,1;
  MoveL k2,v40,fine,tCut\WObj:=wFixB;
  SetDO doLaser,0;
  MoveJ Offs(m1,0,0,30),v800,z20,tMark\WObj:=wFixB;
  MoveL m1,v80,fine,tMark\WObj:=wFixB;
  dot;
ENDPROC

PROC dot()
  PulseDO\PLength:=0.2,doDot;
  WaitTime 0.3;
ENDPROC
ENDMODULE
