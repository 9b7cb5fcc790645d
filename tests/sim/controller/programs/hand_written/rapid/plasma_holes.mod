MODULE PlasmaHoles
  ! Three bolt holes, d = 14, in a flange of 8 mm. Arc on at the centre, lead to the rim, twice half round.
  PERS tooldata tPlasma:=[TRUE,[[0,0,95],[1,0,0,0]],[1.8,[0,0,40],[1,0,0,0],0,0,0]];
  PERS wobjdata wFlange:=[FALSE,TRUE,"",[[400,400,120],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  VAR speeddata vHole:=[15,500,5000,1000];

  CONST robtarget c1:=[[0,50,0],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget c2:=[[-43.3,-25,0],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget c3:=[[43.3,-25,0],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

  PROC main()
    MoveJ Offs(c1,0,0,30), v400, z5, tPlasma\WObj:=wFlange;
    hole1;
    hole2;
    hole3;
  ENDPROC

  ! hole number one
  PROC hole1()
    MoveL c1, v200, fine, tPlasma\WObj:=wFlange;
    SetDO doArc, high;
    WaitTime 0.8;
    MoveL Offs(c1,7,0,0), vHole, z0, tPlasma\WObj:=wFlange;
    MoveC Offs(c1,0,7,0), Offs(c1,-7,0,0), vHole, z0, tPlasma\WObj:=wFlange;
    MoveC Offs(c1,0,-7,0), Offs(c1,7,0,0), vHole, fine, tPlasma\WObj:=wFlange;
    SetDO doArc, low;
  ENDPROC

  PROC hole2()
    MoveL c2, v200, fine, tPlasma\WObj:=wFlange;
    SetDO doArc, high;
    WaitTime 0.8;
    MoveC Offs(c2,3.5,3.5,0), Offs(c2,7,0,0), vHole, z0, tPlasma\WObj:=wFlange;
    MoveC Offs(c2,-7,0,0), Offs(c2,6.9,-1.2,0), vHole, fine, tPlasma\WObj:=wFlange;
    SetDO doArc, low;
  ENDPROC

  PROC hole3()
    MoveL c3, v200, fine, tPlasma\WObj:=wFlange;
    ! this one is only marked: the drill does the rest
  ENDPROC
ENDMODULE
