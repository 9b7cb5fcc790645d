%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%

MODULE C1001
  ! (2D CONTOUR1) posted from CAM, mm
  ! tool: 3 = "laser nozzle 1.5 mm"

  PERS tooldata tool3 := [TRUE,[[0,0,142.6],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  PERS wobjdata wobj_G55 := [FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[700,250,300],[1,0,0,0]]];

  PROC main()
    ConfJ\Off;
    ConfL\Off;
    SingArea\Wrist;
    ! section 1: 2D Contour1
    Section1;
    ! section 2: Bore1
    Section2;
  ENDPROC

  PROC Section1()
    MoveJ [[-5.,22.5,15.],[0.,1.,0.,0.],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v400, fine, tool3\WObj:=wobj_G55;
    MoveL [[-5.,22.5,0.],[0.,1.,0.,0.],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], [16.7,500,5000,1000], fine, tool3\WObj:=wobj_G55;
    MoveC [[-1.464,26.036,0.],[0.,1.,0.,0.],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], [[0.,27.5,0.],[0.,1.,0.,0.],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], [16.7,500,5000,1000], z0, tool3\WObj:=wobj_G55;
    MoveL [[0.,75.,0.],[0.,1.,0.,0.],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], [33.3,500,5000,1000], z0, tool3\WObj:=wobj_G55;
    MoveL [[50.,75.,0.],[0.,1.,0.,0.],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], [33.3,500,5000,1000], z0, tool3\WObj:=wobj_G55;
    MoveL [[50.,75.,15.],[0.,1.,0.,0.],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v400, fine, tool3\WObj:=wobj_G55;
  ENDPROC

  PROC Section2()
    MoveL [[25.,50.,15.],[0.,1.,0.,0.],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v400, fine, tool3\WObj:=wobj_G55;
    MoveL [[29.,50.,0.],[0.,1.,0.,0.],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v100, fine, tool3\WObj:=wobj_G55;
    MoveC [[25.,54.,0.],[0.,1.,0.,0.],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], [[21.,50.,0.],[0.,1.,0.,0.],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], [16.7,500,5000,1000], z1, tool3\WObj:=wobj_G55;
    MoveC [[25.,46.,0.],[0.,1.,0.,0.],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], [[29.,50.,0.],[0.,1.,0.,0.],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], [16.7,500,5000,1000], fine, tool3\WObj:=wobj_G55;
  ENDPROC
ENDMODULE
