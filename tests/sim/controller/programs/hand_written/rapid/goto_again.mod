MODULE Again
! my father's program from the S3 times, typed in again. It polishes until somebody stops it
CONST robtarget t1:=[[450,100,300],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget t2:=[[450,160,300],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
MoveJ t1,v200,fine,tool0;
again:
MoveL t2,v60,z5,tool0;
MoveL t1,v60,z5,tool0;
GOTO again;
ENDPROC
! the felt is changed here, by hand: jump into this routine
PROC felt()
MoveJ Offs(t1,0,0,150),v200,fine,tool0;
TPWrite "new felt";
ENDPROC
ENDMODULE
