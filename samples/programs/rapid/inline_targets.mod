MODULE InlineTargets
    ! Targets written in the instruction, as a controller writes them: six significant digits, exponents,
    ! unused external axes as 9E9, 9E+09 or 1E+10. An external axis (the track, 1250.5) stays as it is.
    PROC main()
        MoveAbsJ [[0,-15.25,20.5,9.60894E-05,45,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]]\NoEOffs, v500, z50, tool0;
        MoveAbsJ [[24.6137,-3.90112,31.0442,-12.5,52.7705,-8.14],[9E9,9E9,9E9,9E9,9E9,9E9]]\NoEOffs, v500, z10, tool0;
        MoveAbsJ [[18.3,2.75,24.8,-12.5,48.25,.384],[1E+10,1E+10,1E+10,1E+10,1E+10,1E+10]]\NoEOffs, v200, fine, tool0;
        MoveAbsJ [[31,-6.5,40.125,-20.75,30,15],[1250.5,9E9,9E9,9E9,9E9,9E9]], v200, z1, tool0\WObj:=wobj0;
        MoveAbsJ [[0,-15.25,20.5,0,45,0],[1250.5,9E9,9E9,9E9,9E9,9E9]]\NoEOffs, v500, fine, tool0;
    ENDPROC
ENDMODULE
