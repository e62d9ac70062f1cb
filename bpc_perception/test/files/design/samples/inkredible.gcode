; Written after "G-CODE COMMANDS" for the CELLINK INKREDIBLE(+), version 2 of 2017, as Slic3r with
; tool change code for it writes: the valves push ink out, E has no meaning.
G21 ; Sets units to millimeters
G90
M82
M750 ; homes the printheads
M751 ; printhead 1 active
G0 X0 Y0 Z0.2
M760 ; opens the valve for printhead 1
G1 X10 Y0 E1 F600
G1 X10 Y10 E2
M761
G1 X0 Y10 E3
M752 ; printhead 2 active
T1
M762
G4 P200
G1 X0 Y0
M763
M764 ; UV LED on
G0 X50 Y50
M765
