MODULE DeclaredTargets
    ! One declared target used by several moves: where they want different values it gets a clone beside it.
    ! jStart hides behind a routine's own jStart; jPark is read by a test, so its value must stay.
    CONST jointtarget jHome:=[[0,-20,25,0,60,0],[9E9,9E9,9E9,9E9,9E9,9E9]]; ! taught
    LOCAL PERS jointtarget jPark:=[[-45,-30,40,0,50,10],[9E9,9E9,9E9,9E9,9E9,9E9]];
    PERS jointtarget jStart:=[[12.5,-10,30,5,55,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
    VAR num nOffset:=0;

    PROC main()
        MoveAbsJ jHome\NoEOffs,v300,fine,tool0;
        MoveAbsJ jStart\NoEOffs,v300,z10,tool0;
        MoveAbsJ jHome\NoEOffs,v300,z10,tool0;
        MoveAbsJ jPark\NoEOffs,v300,fine,tool0;
        nOffset:=jPark.robax.rax_1;
        Inspect;
        MoveAbsJ jHome\NoEOffs,v300,fine,tool0;
    ENDPROC

    PROC Inspect()
        CONST jointtarget jStart:=[[30,-5,20,0,65,45],[9E9,9E9,9E9,9E9,9E9,9E9]];
        VAR jointtarget jAway:=[[35,-5,20,0,65,30],[9E9,9E9,9E9,9E9,9E9,9E9]];
        MoveAbsJ jStart\NoEOffs,v100,fine,tool0;
        MoveAbsJ jAway\NoEOffs,v100,fine,tool0;
        MoveAbsJ jStart\NoEOffs,v100,fine,tool0;
    ENDPROC
ENDMODULE
