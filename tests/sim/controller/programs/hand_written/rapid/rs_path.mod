MODULE Module1
    !***********************************************************
    !
    ! Module:  Module1
    !
    ! Description:
    !   Water jet, outer trim of a door panel (station "DoorTrim_v7")
    !
    ! Author: planning
    !
    ! Version: 1.0
    !
    !***********************************************************
    TASK PERS tooldata tWaterJet:=[TRUE,[[0,0,265.500000],[0.707106781,0,0.707106781,0]],[4,[0,0,120],[1,0,0,0],0,0,0]];
    TASK PERS wobjdata Workobject_1:=[FALSE,TRUE,"",[[1025.000000,-310.500000,640.000000],[1,0,0,0]],[[0,0,0],[0.965925826,0,0,0.258819045]]];
    CONST robtarget Target_10:=[[0,0,50],[0,0.707106781,0.707106781,0],[-1,0,-1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget Target_20:=[[0,0,0],[0,0.707106781,0.707106781,0],[-1,0,-1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget Target_30:=[[149.999999999,0.000000113,0],[0,0.707106781,0.707106781,0],[-1,0,-1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget Target_40:=[[174.246404719,13.939339828,-1.25],[0,0.707106781,0.707106781,0],[-1,-1,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget Target_50:=[[180,30,-2.5],[0,0.707106781,0.707106781,0],[-1,-1,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST robtarget Target_60:=[[180,120.75,-2.5],[0,0.707106781,0.707106781,0],[-1,-1,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    CONST jointtarget JointTarget_1:=[[0,-20,25,0,60,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    PROC main()
        !Add your code here
        MoveAbsJ JointTarget_1,v1000,z100,tWaterJet\WObj:=wobj0;
        Path_10;
        MoveAbsJ JointTarget_1,v1000,fine,tWaterJet\WObj:=wobj0;
    ENDPROC
    PROC Path_10()
        MoveJ Target_10,v1000,z100,tWaterJet\WObj:=Workobject_1;
        MoveL Target_20,v150,fine,tWaterJet\WObj:=Workobject_1;
        MoveL Target_30,v80,z5,tWaterJet\WObj:=Workobject_1;
        MoveL Target_40,v80,z5,tWaterJet\WObj:=Workobject_1;
        MoveL Target_50,v80,z5,tWaterJet\WObj:=Workobject_1;
        MoveL Target_60,v80,fine,tWaterJet\WObj:=Workobject_1;
    ENDPROC
ENDMODULE
