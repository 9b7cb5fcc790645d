MODULE Override
  ! night shift: everything at 60 %
  CONST robtarget pN:=[[480,-90,260],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    AccSet 40,40;   VelSet 60,800;
    MoveJ pN,v500,fine,tool0;
    MoveL Offs(pN,40,0,0),v50,z1,tool0;
    MoveL Offs(pN,40,40,0),v50,fine,tool0;
    MoveL Offs(pN,0,40,0),v50,z1,tool0;
    MoveL pN,v50,fine,tool0;
    VelSet 100,5000;
    AccSet 100,100;
    MoveJ Offs(pN,0,0,100),v500,fine,tool0;
  ENDPROC
ENDMODULE