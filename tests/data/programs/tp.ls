/PROG  WELD
/ATTR
COMMENT = "";
/MN
   1:  !weld the seam ;
   2:  UFRAME_NUM=0 ;
   3:J P[1] 50% FINE    ;
   4:L P[2:begin] 250mm/sec CNT50    ;
   5:L P[3] 1200cm/min FINE Offset,PR[1]    ;
   6:L P[3] 1200cm/min FINE    ;
   7:C P[2]
    :  P[3] 100mm/sec FINE    ;
   8:J PR[4] 100% FINE    ;
   9:  CALL GRIP    ;
  10:J P[4] 100% CNT100    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 0,	
	J1=     0.000 deg,	J2=     10.000 deg,	J3=   -20.000 deg,
	J4=     0.000 deg,	J5=   -50.000 deg,	J6=     0.000 deg
};
P[2:"begin"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   420.000  mm,	Y =  -80.000  mm,	Z =   180.000  mm,
	W =   178.000 deg,	P =  -10.000 deg,	R =     5.000 deg
};
P[3]{
   GP1:
	UF : 0, UT : 0,		CONFIG : 'N U T, 0, 0, 0',
	X =   420.000  mm,	Y =   80.000  mm,	Z =   180.000  mm,
	W =   178.000 deg,	P =  -10.000 deg,	R =     5.000 deg
   GP2:
	UF : 0, UT : 0,
	J1=     7.000 deg
};
P[4]{
   GP1:
	UF : 0, UT : 0,		CONFIG : 'N U T, 0, 0, 0',
	X =  ********  mm,	Y =   80.000  mm,	Z =   180.000  mm,
	W =   178.000 deg,	P =  -10.000 deg,	R =     5.000 deg
};
/END
