MODULE Grid
  ! spot grid 5 x 1, one spot every 20 mm
  CONST robtarget pGrid:=[[400,-40,250],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS tooldata tSpot:=[TRUE,[[0,0,140],[1,0,0,0]],[2,[0,0,50],[1,0,0,0],0,0,0]];
  VAR num i;
  PROC main()
    MoveJ Offs(pGrid,0,0,40), v500, z10, tSpot;
    FOR i FROM 0 TO 4 DO
      MoveL Offs(pGrid,20*i,0,0), v100, fine, tSpot;
      SetDO doSpot, 1;
      WaitTime 0.2;
      SetDO doSpot, 0;
    ENDFOR
    MoveL Offs(pGrid,80,0,40), v200, fine, tSpot;
  ENDPROC
ENDMODULE
