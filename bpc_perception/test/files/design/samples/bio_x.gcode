; Code beginning
; Pneumatic printhead selected
; Written after MaiGitCodes/BioXGCodeGenerator, core/gcode.py, and CELLINK's G-code guide for the
; BIO X: E opens the valve in a move, M750 T starts a printhead, G7 is a relative move.
G21 ; set units to millimeters
G90 ; use absolute coordinates
M83 ; use relative distances for extrusion
T1 Z0.00 ; set printhead number 1
M773 T1 P25.0 ; Set default pressure for printhead 1
G1 X-10.000 Y10.000 F3000.0 ; Move to
G1 Z0.40 F3000.0
G1 X-10.000 Y-10.000 E0.94 F1200.0 ; Extruding to
G1 Z1.40
G0 X0 Y-10 Z0.4
G7 X0 Y20 E0.94 F1200
M750 T1 P25 D2; drop for 2 seconds
M750 T1 P25
G1 X5 Y10
M751 T1 ; Stop pneumatic extrusion
G0 Z50; move bed to parking position
M400
M84
