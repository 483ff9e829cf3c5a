/PROG  WELDING
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "weld";
PROG_SIZE	= 1024;
CREATE		= DATE 26-11-02  TIME 08:15:00;
MODIFIED	= DATE 26-11-02  TIME 08:20:00;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 18;
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
   1:  !Shows: welds, arcs, actions ;
   2:  UFRAME_NUM=0 ;
   3:  UTOOL_NUM=1 ;
   4:J P[1] 100% CNT100    ;
   5:J P[2] 80% FINE Wjnt ACC60 TB    .10sec,DO[3]=ON    ;
   6:L P[3] 250mm/sec FINE Weld Start[1,1]    ;
   7:L P[4] 60cm/min CNT100    ;
   8:C P[5]    
    :  P[6] 60cm/min CNT100    ;
   9:A P[4] 60cm/min CNT100    ;
  10:L P[6] 20inch/min FINE    
    :  Weld End[1,1]    ;
  11:  Arc Start[2] ;
  12:L P[3] 60cm/min FINE    ;
  13:  Arc End[2] ;
  14:  !lostmotion: off ;
  15:J P[1] 100% FINE SPOT[P=1,S=2] DO[4]=PULSE,0.5sec    ;
  16:  !lostmotion: on ;
  17:J P[2] 2.0sec FINE    ;
  18:J P[1] 100% FINE    ;
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
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   890.000  mm,	Y =      .500  mm,	Z =   800.000  mm,
	W =   180.000 deg,	P =   -90.000 deg,	R =      .000 deg
};
P[4]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   880.000  mm,	Y =    20.000  mm,	Z =   790.000  mm,
	W =   180.000 deg,	P =   -90.000 deg,	R =      .000 deg
};
P[5]{
   GP1:
	UF : 2, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   870.000  mm,	Y =    30.000  mm,	Z =   790.000  mm,
	W =   180.000 deg,	P =   -90.000 deg,	R =      .000 deg
};
P[6]{
   GP1:
	UF : 0, UT : 0,		CONFIG : 'N U T, 0, 0, 0',
	X =   860.000  mm,	Y =    40.000  mm,	Z =   790.000  mm,
	W =   180.000 deg,	P =   -90.000 deg,	R =      .000 deg
};
/END
