MODULE ZonesAndSpeeds
    ! Speeds and zones of the language and of the program, \V, \Z, and a time \T for a whole move, which new points share out.
    CONST speeddata vSlow:=[25,10,5000,1000];
    CONST zonedata zTight:=[FALSE,0.5,0.5,0.5,0.05,0.5,0.05];
    CONST zonedata zStop:=[TRUE,0,0,0,0,0,0];
    CONST jointtarget jA:=[[0,-10,20,0,45,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST jointtarget jB:=[[20,-5,15,10,40,5],[9E9,9E9,9E9,9E9,9E9,9E9]];
    VAR num nSeconds:=3;

    PROC main()
        MoveAbsJ jA,vmax,fine\Inpos:=inpos20,tool0;
        MoveAbsJ jB,vSlow,zTight,tool0;
        MoveAbsJ jA,v100\V:=80,z0,tool0;
        MoveAbsJ jB,v100,z10\Z:=4,tool0;
        MoveAbsJ jA,v100\T:=2.5,z1,tool0;
        MoveAbsJ \Conc,jB,v100,zStop,tool0;
        SetDO doLamp,1;
        ! a time that is not a number cannot be shared out
        MoveAbsJ jA,v100\T:=nSeconds,fine,tool0;
    ENDPROC
ENDMODULE
