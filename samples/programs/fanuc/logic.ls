/PROG  LOGIC
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "";
PROG_SIZE	= 1024;
CREATE		= DATE 26-11-02  TIME 08:15:00;
MODIFIED	= DATE 26-11-02  TIME 08:20:00;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 30;
MEMORY_SIZE	= 1500;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/APPL
/MN
   1:  !Shows: what ends directions ;
   2:  LBL[1:again] ;
   3:J P[1] 100% FINE    ;
   4:J P[2] 100% CNT50 TB   0.00sec,P-SPS    ;
      1:  TC_ONLINE (ON) ;
      2:  DO[80]=ON ;
      3:  CALL MAKRO7    ;
       ------ ;
   5:  IF R[1]=3,JMP LBL[2] ;
   6:J P[3] 100% FINE    ;
   7:  SELECT R[2]=1,JMP LBL[1] ;
   8:         =2,CALL SUB2 ;
   9:         ELSE,JMP LBL[2] ;
  10:  FOR R[3]=1 TO 5 ;
  11:J P[1] 100% CNT10    ;
  12:J P[2] 100% CNT10    ;
  13:  ENDFOR ;
  14://J P[3] 100% FINE    ;
  15:  SKIP CONDITION DI[1]=ON    ;
  16:L P[2] 100mm/sec FINE Skip,LBL[2]    ;
  17:J P[3] 100% FINE INC    ;
  18:J P[3] 100% FINE Offset,PR[1]    ;
  19:J PR[4] 100% FINE    ;
  20:J P[R[5]] 100% FINE    ;
  21:  P[4]=LPOS    ;
  22:J P[4] 100% FINE    ;
  23:   ;
  24:  OVERRIDE=50% ;
  25:J P[1] 100% FINE    ;
    :J P[2] 100% FINE    ;
  26:  CALL GRIPPER(1) ;
  27:  WAIT DI[4]=ON    ;
  28:  RUN OTHER ;
  29:J P[9] 100% FINE    ;
  30:  LBL[2] ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,	
	J1=      .384 deg,	J2=   -10.000 deg,	J3=    35.130 deg,
	J4=     -.250 deg,	J5=   -62.500 deg,	J6=    12.000 deg
};
P[2]{
   GP1:
	UF : 0, UT : 1,	
	J1=    25.500 deg,	J2=    15.250 deg,	J3=    10.000 deg,
	J4=      .000 deg,	J5=   -45.000 deg,	J6=   -30.125 deg
};
P[3]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -18.000 deg,	J2=     4.500 deg,	J3=    22.750 deg,
	J4=    10.000 deg,	J5=   -80.000 deg,	J6=    -5.000 deg
};
P[4]{
   GP1:
	UF : 0, UT : 1,	
	J1=      .384 deg,	J2=   -10.000 deg,	J3=    35.130 deg,
	J4=     -.250 deg,	J5=   -62.500 deg,	J6=    12.000 deg
};
/END
