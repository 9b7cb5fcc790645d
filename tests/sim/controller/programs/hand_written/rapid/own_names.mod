MODULE OwnNames
  ! The names v100 and z10 are mine in this module, and slower: the old hands at line 2 want it so.
  LOCAL CONST speeddata v100 := [55, 500, 5000, 1000];
  LOCAL CONST zonedata z10 := [FALSE, 4, 6, 6, 0.6, 6, 0.6];
  LOCAL CONST zonedata fine_ := [TRUE, 0, 0, 0, 0, 0, 0];
  LOCAL CONST speeddata set_speed := [22.25, 500, 5000, 1000];
  LOCAL CONST robtarget movel_1 := [[300, 300, 300], [0, 1, 0, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  LOCAL CONST robtarget procedure1 := [[330, 300, 300], [0, 1, 0, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  LOCAL CONST robtarget endproc_ := [[330, 330, 300], [0, 1, 0, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  PROC main()
    MoveJ movel_1, v200, z10, tool0;
    Offs1;
    MoveL procedure1, v100, z10, tool0;
    MoveL endproc_, set_speed, fine_, tool0;
    ReSet doOff;
    MOVEl Movel_1, V100, Z10, Tool0;
    moveL PROCEDURE1, v150, FINE, TOOL0;
  ENDPROC
  LOCAL PROC Offs1()
    setDO doOn, 1;
    WAITTIME 0.1;
  ENDPROC
ENDMODULE
