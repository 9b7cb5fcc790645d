%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%
! exported without the main module: which of the two is started is chosen on the pendant
MODULE TwoPaths
  CONST robtarget u1:=[[0,0,10],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget u2:=[[50,0,10],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC Path_10()
    MoveL u1,v100,fine,tHead\WObj:=wUpper;
    MoveL u2,v40,fine,tHead\WObj:=wUpper;
  ENDPROC
  PROC Path_20()
    MoveL u2,v100,fine,tHead\WObj:=wLower;
    MoveL u1,v40,fine,tHead\WObj:=wLower;
  ENDPROC
ENDMODULE
