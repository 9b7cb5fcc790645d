MODULE Deburr
	PERS tooldata	tBrush	:=	[TRUE,[[0,0,300],[0.7071068,0,0.7071068,0]],[5,[0,0,150],[1,0,0,0],0,0,0]];
	LOCAL CONST zonedata	zCorner	:=	[FALSE,2.5,4,4,0.4,4,0.4];
	LOCAL CONST zonedata	zStop	:=	[TRUE,0,0,0,0,0,0];
	LOCAL CONST zonedata	zTight	:=	[FALSE,.05,.075,.075,.01,.075,.01];
	LOCAL CONST speeddata	vSlow	:=	[7.5E0,50,500,100];
	LOCAL CONST speeddata	vAlso	:=	vSlow;
	LOCAL PERS robtarget	q1	:=	[[1100,-50,800],[0.7071068,0,0.7071068,0],[0,0,0,1],[9E9,9E9,9E9,9E9,9E9,9E9]];

	PROC main()
		AccSet 50, 50;
		MoveJ	q1, v1000, z200, tBrush;
		SetAO	aoSpindle, 4500;
		MoveL	Offs(q1, 40, 0, 0),	v150, z40, tBrush;
		MoveL	Offs(q1, 40, 0, -12.5),	vSlow, zStop, tBrush;
		MoveL	Offs(q1, 40, 50, -12.5),	vSlow, zCorner, tBrush;
		MoveL	Offs(q1, 40, 100, -12.5),	vAlso, zTight, tBrush;
		MoveL	Offs(q1, 40, 100, 62.5),	vSlow, z1, tBrush\WObj:=wobj0;
		MoveL	Offs(q1, 40, 50, 62.5),	v5, fine, tBrush;
		SetAO	aoSpindle, 0;
		AccSet 100, 100;
		MoveL	q1, v7000, z150, tBrush;
	ENDPROC
ENDMODULE
