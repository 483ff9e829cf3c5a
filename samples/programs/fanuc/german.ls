/PROG  PRUEFUNG
/ATTR
EIGENTÜMER	= MNEDITOR;
KOMMENTAR	= "Prüfung";
PROG_GRÖSSE	= 1024;
ERSTELLT	= DATE 26-11-02  TIME 08:15:00;
GEÄNDERT	= DATE 26-11-02  TIME 08:20:00;
DATEINAME	= ;
VERSION		= 0;
ZEILEN		= 12;
SPEICHER	= 1500;
SCHUTZ		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50;
DEFAULT_GROUP	= 1,*,*,*,*;
/APPL
/MN
   1:  !Zeigt: Wörter der Steuerung ;
   2:J P[1] 100% FINE    ;
   3:J P[2] 100% CNT30    ;
   4:  WARTE    .20(sek) ;
   5:J P[1] 100% FINE    ;
   6:  SPRUNG MRK[1] ;
   7:  MRK[1] ;
   8:L P[3] 100mm/sec FINE Lichtbogen Start[1]    ;
   9:L P[4] 50cm/min FINE Lichtbogen Ende[1]    ;
  10:J P[2] 100% FINE VERSATZ,PR[1]    ;
  11:J P[2] 100% FINE INK    ;
  12:J P[1] 100% FINE    ;
/POS
P[1:"Grundst."]{
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
	UF : 0, UT : 1,		KONFIG : 'N U T, 0, 0, 0',
	X =   890.000  mm,	Y =      .500  mm,	Z =   800.000  mm,
	W =   180.000 deg,	P =   -90.000 deg,	R =      .000 deg
};
P[4]{
   GP1:
	UF : 0, UT : 1,		KONFIG : 'N U T, 0, 0, 0',
	X =   880.000  mm,	Y =    20.000  mm,	Z =   790.000  mm,
	W =   180.000 deg,	P =   -90.000 deg,	R =      .000 deg
};
/END
