/PROG  SHARED
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "";
PROG_SIZE	= 1024;
CREATE		= DATE 26-11-02  TIME 08:15:00;
MODIFIED	= DATE 26-11-02  TIME 08:20:00;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 9;
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
   1:  !Shows: one point, many moves ;
   2:J P[1:wait] 100% FINE    ;
   3:J P[2] 100% CNT20    ;
   4:J P[1:wait] 100% FINE    ;
   5:J P[7] 100% CNT20    ;
   6:J P[1:wait] 100% FINE    ;
   7:  --eg:indices are not in a row ;
   8:  PR[5]=P[7]    ;
   9:J P[7] 10% FINE    ;
/POS
P[1:"wait"]{
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
P[7]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -18.000 deg,	J2=     4.500 deg,	J3=    22.750 deg,
	J4=    10.000 deg,	J5=   -80.000 deg,	J6=    -5.000 deg
};
/END
