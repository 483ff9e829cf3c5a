/PROG  GROUPS
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "";
PROG_SIZE	= 1024;
CREATE		= DATE 26-11-02  TIME 08:15:00;
MODIFIED	= DATE 26-11-02  TIME 08:20:00;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 7;
MEMORY_SIZE	= 1500;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,1,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/APPL
/MN
   1:  !Shows: a rail, a point not taught ;
   2:J P[1] 100% CNT100    ;
   3:J P[2] 100% CNT100    ;
   4:J P[3] 100% FINE    ;
   5:J P[4] 100% FINE    ;
   6:J P[5] 100% FINE    ;
   7:L P[2] 100mm/sec FINE COORD    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,	
	J1=     0.384 deg,	J2=   -10.000 deg,	J3=    35.130 deg,
	J4=    -0.250 deg,	J5=   -62.500 deg,	J6=    12.000 deg
   GP2:
	UF : 0, UT : 1,	
	J1=     0.000  mm
};
P[2]{
   GP1:
	UF : 0, UT : 1,	
	J1=    25.500 deg,	J2=    15.250 deg,	J3=    10.000 deg,
	J4=     0.000 deg,	J5=   -45.000 deg,	J6=   -30.125 deg
   GP2:
	UF : 0, UT : 1,	
	J1=     0.000  mm
};
P[3]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -18.000 deg,	J2=     4.500 deg,	J3=    22.750 deg,
	J4=    10.000 deg,	J5=   -80.000 deg,	J6=    -5.000 deg
   GP2:
	UF : 0, UT : 1,	
	J1=  1500.000  mm
};
P[4]{
   GP1:
	UF : 0, UT : 1,	
	J1=     0.384 deg,	J2=   -10.000 deg,	J3=    35.130 deg,
	J4=    -0.250 deg,	J5=   -62.500 deg,	J6=    12.000 deg
   GP2:
	UF : 0, UT : 1,	
	J1=  1500.000  mm
};
P[5]{
   GP1:
	UF : F, UT : F,	
	J1=  ******** deg,	J2=  ******** deg,	J3=  ******** deg,
	J4=  ******** deg,	J5=  ******** deg,	J6=  ******** deg
   GP2:
	UF : 0, UT : 1,	
	J1=     0.000  mm
};
/END
