%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%

MODULE Halter
	! Halter 4 Stück, Blech 2 mm, Düse Ø 1,2 - alte Vorrichtung (nicht die neue!)	
	! MoveL NIE schneller als v30, sonst Grat; WHILE es raucht: Absaugung prüfen
	PERS tooldata tKopf:=[TRUE,[[12.4,-3.1,187.25],[0,0,1,0]],[3.5,[0,0,70],[1,0,0,0],0,0,0]];
	PERS wobjdata wAuflage:=[FALSE,TRUE,"",[[650,-220,410],[1,0,0,0]],[[0,0,2],[1,0,0,0]]];

	CONST robtarget pEck:=[[10,10,0],[1,0,0,0],[0,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

	PROC Strahl_ein()
		SetDO doLaser,1;	! Pause fürs Einstechen   
		WaitTime 0.4;
	ENDPROC

	PROC Rand()
		MoveL pEck,v60,fine,tKopf\WObj:=wAuflage;
		Strahl_ein;
		MoveL Offs(pEck,60,0,0),v30,z1,tKopf\WObj:=wAuflage;   
		MoveL Offs(pEck,60,40,0),v30,z1,tKopf\WObj:=wAuflage;
		MoveL Offs(pEck,0,40,0),v30,z1,tKopf\WObj:=wAuflage;
		MoveL pEck,v30,fine,tKopf\WObj:=wAuflage;
		SetDO doLaser,0;
	ENDPROC

	! hier geht es los
	PROC main()
		MoveJ Offs(pEck,0,0,80),v500,z20,tKopf\WObj:=wAuflage;
		Rand;
		MoveL Offs(pEck,0,0,80),v200,fine,tKopf\WObj:=wAuflage;
		TPWrite "Halter fertig, Teil herausnehmen";
	ENDPROC
ENDMODULE
