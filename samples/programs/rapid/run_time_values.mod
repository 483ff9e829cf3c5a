MODULE RunTimeValues
    ! Targets that are not certain from the text, and why: assigned, passed to a routine that may set it, chosen by a computed
    ! index, computed, declared elsewhere. Only jFixed and jPath{2} can be edited; jPath{2} gets a clone, as the loop reads jPath.
    CONST jointtarget jFixed:=[[5,-12,28,0,50,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST jointtarget jPath{3}:=[[[10,-12,28,0,50,0],[9E9,9E9,9E9,9E9,9E9,9E9]],
        [[15,-14,30,0,50,0],[9E9,9E9,9E9,9E9,9E9,9E9]],
        [[20,-16,32,0,50,0],[9E9,9E9,9E9,9E9,9E9,9E9]]];
    VAR jointtarget jNow:=[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    PERS jointtarget jTaught:=[[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pPick:=[[700,150,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    VAR num nAngle:=10;

    PROC main()
        MoveAbsJ jFixed,v200,fine,tool0;
        jNow:=CJointT();
        jNow.robax.rax_1:=nAngle;
        MoveAbsJ jNow,v200,fine,tool0;
        Teach jTaught;
        MoveAbsJ jTaught,v200,fine,tool0;
        MoveAbsJ jPath{2},v200,z10,tool0;
        FOR i FROM 1 TO 3 DO
            MoveAbsJ jPath{i},v200,z10,tool0;
        ENDFOR
        MoveAbsJ [[nAngle,-12,28,0,50,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v200,fine,tool0;
        MoveAbsJ CalcJointT(pPick,tool0),v200,fine,tool0;
        MoveAbsJ jOfTheCellModule,v200,fine,tool0;
        MoveL Offs(pPick,0,0,50),v100,fine,tool0;
    ENDPROC

    PROC Teach(INOUT jointtarget jWhere)
        jWhere:=CJointT();
    ENDPROC
ENDMODULE
