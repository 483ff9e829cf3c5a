MODULE CartesianAndProcess
    ! Cartesian moves stay as they are; where their frame and tool are known, the joints behind them are solved.
    ! Arcs, searches and moves with actions take no new points. The seam is marked as a process.
    CONST jointtarget jReady:=[[0,-10,20,0,45,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pNear:=[[815,0,1000],[0.707107,0,0.707107,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pSeam1:=[[800,100,600],[0.707107,0,0.707107,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pSeam2:=[[800,200,600],[0.707107,0,0.707107,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pSeam3:=[[850,250,600],[0.707107,0,0.707107,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    PERS tooldata tTorch:=[TRUE,[[0,0,350],[1,0,0,0]],[4,[0,0,120],[1,0,0,0],0,0,0]];

    PROC main()
        MoveAbsJ jReady,v500,fine,tool0;
        MoveJ pNear,v500,z10,tool0\WObj:=wobj0;
        MoveL pSeam1,v200,fine,tTorch\WObj:=wTable;
        ArcLStart pSeam1,v100,seam1,weld1,fine,tTorch\WObj:=wTable;
        ArcL pSeam2,v100,seam1,weld1,z1,tTorch\WObj:=wTable;
        ArcCEnd pSeam2,pSeam3,v100,seam1,weld1,fine,tTorch\WObj:=wTable;
        SearchL\Stop,diTouch,pFound,pSeam1,v20,tTorch\WObj:=wTable;
        TriggL pNear,v200,trGun,z5,tool0;
        MoveC pSeam1,pSeam2,v100,z1,tTorch\WObj:=wTable;
        MoveAbsJ jReady,v500,fine,tool0;
    ENDPROC
ENDMODULE
