%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%

MODULE Data(SYSMODULE,NOSTEPIN)
  ! Prüfstellung: header, two modules in one file, CRLF, Latin-1, several statements on a line, a statement on several
  ! lines, words that only look like moves. lostmotion: off and on stand in comments of their own.
  CONST jointtarget jTest:=[ [ 0, -10, 20, 0, 45, 0 ], [ 9E9, 9E9, 9E9, 9E9, 9E9, 9E9 ] ];
ENDMODULE

MODULE Layout
  PROC main()
    TPWrite "MoveAbsJ jTest,v5,fine,tool0; ! ""no move""";
    ! MoveAbsJ jTest,v5,fine,tool0;
    SetDO doA,1; MoveAbsJ jTest,v100,fine,tool0; SetDO doA,0;
    moveabsj [[12,-10,22.5,
               0,45,0],        ! [[9,9
              [9E9,9E9,9E9,9E9,9E9,9E9]],
      v100, z5,
      tool0 \WObj:=wobj0;
    ! lostmotion: off
    MoveAbsJ [[10,-10,22.5,0,45,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v20,fine,tool0;
    ! lostmotion: on
    <SMT>
    MoveAbsJ jTest, v100, fine, tool0;
  ENDPROC
ENDMODULE
