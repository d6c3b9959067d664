MODULE weld
  ! literal targets in mm, quaternions with the real part first
  CONST robtarget p10:=[[350,-60,420],[0.0616284,-0.2418448,0.9659258,-0.0690992],
     [-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS robtarget p20:=[[350,60,420],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR robtarget p30;
  CONST speeddata slow:=[40,90,5000,1000];
  CONST jointtarget home:=[[0,-20,30,0,60,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveAbsJ home\NoEOffs,v500,fine,tool0;
    MoveL p20,v100,z10,tool0\WObj:=wobj0;
    MoveL [[350,-60,420],[0,0,1,0],[-1,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],slow,fine,tool0;
    MoveL p10,v100\V:=25,fine,torch;
    MoveL p20,v100,fine,tool0\WObj:=table1;
    MoveL Offs(p20,0,0,50),v100,fine,tool0;
    MoveJ p30,v100,z10,tool0;
    MoveC p10,p20,v100,z10,tool0;
    IF di1=1 THEN
      p30:=p20;
    ENDIF
    weldseam;
    MoveAbsJ [[10,-20,30,0,60,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v500,fine,tool0;
  ENDPROC
ENDMODULE
