module star
! lab 3, exercise 2: draw a star with the pen
! (i measured the paper with a ruler so it is maybe 1 mm wrong)

  pers tooldata   pen := [true, [[0,0,.115e3],[1,0,0,0]], [0.3,[0,0,50],[1,0,0,0],0,0,0]];
 pers wobjdata paper:=[false , true , "" , [[+500. , -1e2 , 250],[1,0,0,0]] , [[0,0,0],[1,0,0,0]]];

        proc main()

  movej [[  95.106 , 30.902 ,  2e1 ],[0,0,1,0],[0,0,0,0],[9e9,9e9,9e9,9e9,9e9,9e9]] , v200 , z5 , pen \wobj:=paper ;

  ! pen down. why is it fine and not z1? because the pen must really arrive before drawing
  movel [[95.106,30.902,0],[0,0,1,0],[0,0,0,0],[9e9,9e9,9e9,9e9,9e9,9e9]],v50,fine,pen\wobj:=paper;
      movel [[-9.5106E1,+30.902,-0.0],[0,0,1,0],[0,0,0,0],[9e9,9e9,9e9,9e9,9e9,9e9]],v50,z1,pen\wobj:=paper;

    movel [[58.779,-80.902,0.],[0,0,1,0],[0,0,0,0],[9e9,9e9,9e9,9e9,9e9,9e9]],v50,z1,pen\wobj:=paper;


    movel [[0,.1E+3,0],[0,0,1,0],[0,0,0,0],[9e9,9e9,9e9,9e9,9e9,9e9]],v50,z1,pen\wobj:=paper;
    movel [[-58.779,-80.902,-.0],[0,0,1,0],[0,0,0,0],[9e9,9e9,9e9,9e9,9e9,9e9]],v50,z1,pen\wobj:=paper;
    movel [[95.106,30.902,00.000],[0,0,1,0],[0,0,0,0],[9e9,9e9,9e9,9e9,9e9,9e9]],v50,fine,pen\wobj:=paper;
    tpwrite "star done :-)";
   ! movel home ???   <- ask in the next lab
  endproc


endmodule