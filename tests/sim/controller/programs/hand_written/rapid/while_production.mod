%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%
MODULE MainModule
	CONST robtarget pHome:=[[600,0,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
	VAR num nParts:=0;

	PROC Cut()
		MoveL Offs(pHome,20,0,-100),v100,fine,tool0;
		MoveL Offs(pHome,60,0,-100),v40,fine,tool0;
	ENDPROC

	PROC main()
		MoveJ pHome,v500,fine,tool0;
		TPWrite "für immer"; WHILE TRUE DO
			WaitDI diPart,1;
			Cut;
			MoveJ pHome,v500,fine,tool0;
			nParts:=nParts+1;
		ENDWHILE
	ENDPROC
ENDMODULE
