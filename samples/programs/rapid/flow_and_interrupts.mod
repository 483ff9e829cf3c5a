MODULE FlowAndInterrupts
    ! What ends a known direction: routines, branches, loops, labels, calls that may move, interrupts, displacements, handlers.
    ! What does not: waits, signals, a test without moves, OpenGripper (which is in this file and does not move).
    CONST jointtarget jA:=[[0,-10,20,0,45,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST jointtarget jB:=[[15,-10,25,0,45,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    VAR intnum iStop;

    PROC main()
        CONNECT iStop WITH tStop;
        ISignalDI diStop,1,iStop;
        MoveAbsJ jA,v200,fine,tool0;
        WaitTime 0.5;
        OpenGripper;
        IF diPart=0 THEN
            TPWrite "no part!";
        ENDIF
        MoveAbsJ jB,v200,fine,tool0;
        IF diPart=1 MoveAbsJ jA,v200,fine,tool0;
        WHILE diRun=1 DO
            MoveAbsJ jB,v200,z10,tool0;
            MoveAbsJ jA,v200,z10,tool0;
        ENDWHILE
        TEST nType
        CASE 1,2:
            MoveAbsJ jB,v200,fine,tool0;
        DEFAULT:
            OtherModulesWork;
        ENDTEST
again:
        MoveAbsJ jA,v200,fine,tool0;
        IF diAgain=1 GOTO again;
        PDispOn pBase,tool0;
        MoveAbsJ jB,v200,fine,tool0;
        PDispOff;
    ERROR
        MoveAbsJ jA,v50,fine,tool0;
        RETRY;
    ENDPROC

    PROC OpenGripper()
        SetDO doOpen,1;
        WaitDI diOpen,1;
    ENDPROC

    TRAP tStop
        StopMove;
    ENDTRAP
ENDMODULE
