MODULE offs_spellings
 !----------------------------------------------------------------
 ! test piece for the new programmer: every way to write a length
 !----------------------------------------------------------------
 CONST robtarget pRef:=[[+450.125,-0,1.5E+2],[0,0,-1,-0.0],[0,0,0,0],[9E9,9E+9,9e09,9E+09,9.0E9,9.E9]];
 PROC main()
 MoveL pRef,v100,fine,tool0;
 MoveL Offs(pRef,10,0,0),v100,z1,tool0;
 MoveL Offs ( pRef , +10 , 10.0 , -0 ) , v100 , z1 , tool0 ;
 MoveL Offs(pRef,.5,10.,0.),v100,z1,tool0;
 MoveL Offs(pRef,-.5,-10.,-0.0),v100,z1,tool0;
 MoveL Offs(pRef,1E1,-1e1,+0),v100,z1,tool0;
 MoveL Offs(pRef,1.0E+01,0.0000001,-25E-1),v100,z1,tool0;
 MoveL Offs(pRef,0010,0,00.0),v100,z1,tool0;
 MoveL Offs(pRef,123.456789012345,0,.1e-2),v100,z1,tool0;
 MoveL OFFS(pRef,- 2.5,+ 2.5,0),v100,fine,tool0;
 ENDPROC
ENDMODULE
