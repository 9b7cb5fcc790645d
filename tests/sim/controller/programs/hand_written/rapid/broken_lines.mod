MODULE Broken
  ! I like one argument a line, so that I can read it on the small screen

  ! y was -75.0 until Friday [see the note at the cabinet]
  CONST robtarget pA :=
  [
    [ 600,
      -75.5,
      420 ],
    [ 0, 0, 1, 0 ],
    [ 0, 0, 0, 0 ],
    [ 9E9, 9E9, 9E9,
      9E9, 9E9, 9E9 ]
  ];

  ! measured with four points [max 0.6 mm]; next time with six
  PERS tooldata tSpray :=
    [ TRUE,
      [ [ 0, 0, 175 ], [ 1, 0, 0, 0 ] ],
      [ 2.2, [ 0, 0, 60 ], [ 1, 0, 0, 0 ], 0, 0, 0 ] ];

  PROC
  main
  (
  )
    MoveJ
      pA,
      v200,
      z30,
      tSpray;
    ! along the edge, towards the door
    MoveL
      Offs
      ( pA,
        100,
        0,
        0
      ),
      v80,
      z5,
      tSpray
      \WObj
      :=
      wobj0
    ;
    !MoveL pA, v80, z1, tSpray;
    WaitTime
      0.5
    ;
    MoveC Offs(pA, 125, 25, 0),
          Offs(pA, 150,  0, 0),
          v80, fine, tSpray;

    MoveL pA, v200,
              fine, tSpray;
  ENDPROC
ENDMODULE
