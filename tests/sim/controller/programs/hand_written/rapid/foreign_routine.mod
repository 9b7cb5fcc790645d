MODULE UsesLibrary
  ! rBeamOn and rBeamOff are in LaserLib.sys, which is loaded at the start of the controller
  PERS tooldata tLas:=[TRUE,[[0,0,200],[1,0,0,0]],[5,[0,0,100],[1,0,0,0],0,0,0]];
  CONST robtarget pO:=[[0,0,300],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveJ Offs(pO,500,0,0),v500,fine,tLas;
    cut;
  ENDPROC
  ! capot gauche, découpe extérieure
  PROC cut()
    MoveL Offs(pO,510,0,-20),v100,fine,tLas;
    TPWrite "« découpé »"; rBeamOn;
    MoveL Offs(pO,560,0,-20),v30,fine,tLas;
    rBeamOff;
  ENDPROC
ENDMODULE
