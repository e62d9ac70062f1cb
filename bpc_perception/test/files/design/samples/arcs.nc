%
O1000 (written after NIST IR 6556 and trevorjehl/VPD, Testing: needle prints in arcs)
N10 G20 G90 G17 *5
N20 M83
n30 g0x1y0z.1
N40 g3 x0 y1 i-1 j0 e1 ; a quarter, counter-clockwise
X-1 Y0 I0 J-1 E1 ; modal: goes on as G3
N50 G21
G0 X10 Y0
G2 X10 Y0 Z5.08 I-5 J0 E2 ; a whole turn down to up, clockwise
G0 X0 Y0
G2 X10 Y0 R5 E1
G0 X0 Y0
G2 X0 Y5 R-3 E1
%
