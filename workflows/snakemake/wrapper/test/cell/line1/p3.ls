/PROG  P3
/ATTR
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:J P[1] 50% FINE ;
   2:J P[2] 50% FINE ;
   3:J P[3] 50% FINE ;
   4:J P[4] 50% FINE ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,	
	J1=     1.411 deg,	J2=   -94.950 deg,	J3=    90.000 deg,
	J4=     0.000 deg,	J5=    13.000 deg,	J6=     0.000 deg
};
P[2]{
   GP1:
	UF : 0, UT : 1,	
	J1=    -5.298 deg,	J2=   -94.682 deg,	J3=    92.350 deg,
	J4=     1.500 deg,	J5=    13.000 deg,	J6=    -1.000 deg
};
P[3]{
   GP1:
	UF : 0, UT : 1,	
	J1=    -9.516 deg,	J2=   -93.268 deg,	J3=    92.922 deg,
	J4=     3.000 deg,	J5=    13.000 deg,	J6=    -2.000 deg
};
P[4]{
   GP1:
	UF : 0, UT : 1,	
	J1=    -9.258 deg,	J2=   -91.054 deg,	J3=    91.282 deg,
	J4=     4.500 deg,	J5=    13.000 deg,	J6=    -3.000 deg
};
/END
