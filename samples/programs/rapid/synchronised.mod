MODULE Synchronised
    ! Two robots that move together (\ID between SyncMoveOn and SyncMoveOff): values can be edited, points cannot be added,
    ! as the other robot's program would need them too.
    PERS tasks lArms{2}:=[["T_ROB1"],["T_ROB2"]];
    VAR syncident s1;
    VAR syncident s2;
    PROC main()
        MoveAbsJ [[0,-10,20,0,45,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v200,fine,tool0;
        SyncMoveOn s1,lArms;
        MoveAbsJ [[10,-8,18,0,45,5],[9E9,9E9,9E9,9E9,9E9,9E9]]\ID:=10,v200,z10,tool0;
        MoveAbsJ [[5,-9,21,0,45,0],[9E9,9E9,9E9,9E9,9E9,9E9]]\ID:=20,v200,fine,tool0;
        SyncMoveOff s2;
        MoveAbsJ [[0,-10,20,0,45,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v200,fine,tool0;
    ENDPROC
ENDMODULE
